"""A picture of a run: how many cores are at work on what, from the first byte that is read to the last one measured.

python -m reports.timeline 2048 docs/timeline.svg
"""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from facezip.character.loading import save_character
from facezip.fit.pipeline import Request, compress_into
from facezip.machine.cores import cores
from reports.watching import STAGES, Moment, undisturbed, watched
from scenes.character import make_character

EXPRESSIONS = 20
# Of the picture, in pixels.
WIDTH, HEIGHT, LEFT, TOP, FOOT = 1060, 180, 56, 24, 100
# Pixels of a column.
COLUMN = 4
LINE = 'stroke="#8a8f98"'


def picture(moments: list[Moment], title: str) -> str:
    """An SVG: time to the right, cores at work upwards, by stage."""
    seconds = undisturbed(moments)
    total = float(seconds.sum())
    count = (WIDTH - LEFT - 20) // COLUMN
    busy = _columns(moments, seconds, count)
    used = {stage: sum(moment.work[stage] for moment in moments) for stage in STAGES}
    share = sum(used.values()) / total / cores()
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {TOP + HEIGHT + FOOT}" '
            'font-family="system-ui, sans-serif" font-size="12">',
            f'<rect width="{WIDTH}" height="{TOP + HEIGHT + FOOT}" fill="#fbfbfc"/>',
            *_areas(busy),
            *_axes(total, count),
            f'<text x="{LEFT}" y="16" fill="#55606e">{title}: {total:.1f} s, {share:.0%} of {cores()} cores; '
            "below, seconds of a core</text>",
            *_key(used),
            "</svg>\n",
        ]
    )


def _columns(moments: list[Moment], seconds: NDArray[np.float64], count: int) -> dict[str, list[float]]:
    """Cores at work in each of the columns of a picture, by stage."""
    ends = np.cumsum(seconds)
    total = ends[-1]
    edges = np.linspace(0, total, count + 1)
    busy = {}
    for stage in STAGES:
        done = np.cumsum([moment.work[stage] for moment in moments])
        busy[stage] = (np.diff(np.interp(edges, [0, *ends], [0, *done])) * count / total).tolist()
    return busy


def _areas(busy: Mapping[str, list[float]]) -> Iterator[str]:
    """All stages up to one, from the last to the first, each in front of those before."""
    tops = np.cumsum([*busy.values()], axis=0).tolist()
    for stage, heights in reversed([*zip(busy, tops, strict=True)]):
        steps = "".join(f"V{_y(height)}H{_x(n + 1)}" for n, height in enumerate(heights))
        yield f'<path d="M{LEFT} {_y(0)}{steps}V{_y(0)}z" fill="{STAGES[stage][0]}"/>'


def _axes(total: float, count: int) -> Iterator[str]:
    for core in range(cores() + 1):
        yield f'<path d="M{LEFT} {_y(core)}H{_x(count)}" {LINE} stroke-dasharray="{"none" if core == 0 else "5 4"}"/>'
        yield f'<text x="{LEFT - 8}" y="{_y(core) + 4}" text-anchor="end" fill="#55606e">{core}</text>'
    yield f'<text x="14" y="{_y(cores() / 2)}" transform="rotate(-90 14 {_y(cores() / 2)})" text-anchor="middle" '
    yield 'fill="#55606e">cores at work</text>'
    step = next(step for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 1000) if total / step <= 16)
    for tick in np.arange(0, total, step):
        x = round(LEFT + tick / total * count * COLUMN, 1)
        yield f'<text x="{x}" y="{_y(0) + 16}" text-anchor="middle" fill="#55606e">{tick:g} s</text>'


def _key(used: Mapping[str, float]) -> Iterator[str]:
    for number, (stage, seconds) in enumerate(used.items()):
        x, y = LEFT + number % 5 * 200, TOP + HEIGHT + 48 + number // 5 * 24
        yield f'<rect x="{x}" y="{y - 10}" width="12" height="12" rx="2" fill="{STAGES[stage][0]}"/>'
        yield f'<text x="{x + 18}" y="{y}" fill="#55606e">{stage}, {seconds:.1f} s</text>'


def _x(column: int) -> int:
    return LEFT + column * COLUMN


def _y(busy: float) -> float:
    # A clock of the system ticks beside the one of the threads: a column may exceed all cores by a little.
    return round(TOP + HEIGHT * (1 - min(busy / cores(), 1.0)), 1)


def main(resolution: int, target: Path) -> None:
    """Make a character, compress it while it is watched, and draw that."""
    with TemporaryDirectory() as place:
        scans = Path(place) / "character"
        save_character(make_character(resolution, EXPRESSIONS), scans)
        moments = watched(lambda: compress_into(scans, Path(place) / "me.facezip", Request(), overwrite=True))
    title = f"{EXPRESSIONS} expressions of {resolution} x {resolution} texels"
    target.write_text(picture(moments, title), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
