"""A picture of a run: how many cores are at work on what, from the first byte that is read to the last one measured.

python -m reports.timeline 2048 docs/timeline.svg
"""

import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from facezip.character.loading import save_character
from facezip.fit.pipeline import Request, compress_into
from facezip.machine.cores import cores
from scenes.character import make_character

EXPRESSIONS = 20
# Seconds between two looks at all threads.
STEP = 0.01
# Looks over which it is seen how many threads want a core.
SOME = 100
REST = "the rest"
# A stage, its colour, and how the modules begin whose functions are its work; a thread is at that of the innermost one.
STAGES = {
    "images decoded": ("#3b6ea5", ("facezip.files.decoding", "facezip.files.bands", "facezip.files.opening")),
    "meshes read": ("#6a4c93", ("facezip.files.obj", "facezip.character.obj_parts", "facezip.character.folder_meshes")),
    "meshes placed": ("#a58ac2", ("facezip.character.placement", "facezip.character.orientation")),
    "registration checked": ("#c9a227", ("facezip.character.alignment", "facezip.character.features")),
    "fitted": ("#b5652b", ("facezip.fit.",)),
    "pack written": ("#2e7d5b", ("facezip.files.images", "facezip.files.writing", "facezip.pack.write")),
    "pack hashed": ("#55606e", ("facezip.pack.verification",)),
    "errors measured": ("#8fb8a3", ("facezip.pack.measure", "facezip.pack.errors")),
    REST: ("#c9ccd1", ()),
}
# This one holds all stages together.
AROUND = "facezip.fit.pipeline"
# Of the picture, in pixels.
WIDTH, HEIGHT, LEFT, TOP, FOOT = 1060, 180, 56, 24, 100
# Of the picture: pixels of a column.
COLUMN = 4
LINE = 'stroke="#8a8f98"'


@dataclass(frozen=True)
class Moment:
    """What happened between two looks.

    Attributes
    ----------
    seconds : how long that took.
    work : seconds on a core by stage.
    waited : seconds that threads were kept from a core by others, of this program or not.
    """

    seconds: float
    work: Mapping[str, float]
    waited: float


class Watch:
    """Looks at all threads of the process while its block runs (Linux)."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        self._end = threading.Event()
        self._watcher = threading.Thread(target=self._run)
        self._main = threading.get_ident()

    def __enter__(self) -> "Watch":
        self._watcher.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._watcher.join()

    def _run(self) -> None:
        before, at, used = dict(self._threads()), perf_counter(), process_time()
        while not self._end.wait(STEP):
            now, after, used_now = dict(self._threads()), perf_counter(), process_time()
            self.moments.append(self._moment(before, now, after - at, used_now - used))
            before, at, used = now, after, used_now

    def _threads(self) -> Iterator[tuple[int, tuple[int, float, float]]]:
        """By the system's number of a thread: Python's, and seconds on a core, and waiting for one."""
        for thread in threading.enumerate():
            if thread is self._watcher or thread.native_id is None or thread.ident is None:
                continue
            try:
                ran, waited, _ = Path(f"/proc/self/task/{thread.native_id}/schedstat").read_text("ascii").split()
            except OSError:
                # It has come to its end.
                continue
            yield thread.native_id, (thread.ident, int(ran) / 1e9, int(waited) / 1e9)

    def _moment(
        self,
        before: Mapping[int, tuple[int, float, float]],
        now: Mapping[int, tuple[int, float, float]],
        passed: float,
        used: float,
    ) -> Moment:
        frames = sys._current_frames()
        otherwise = stage_of(frames.get(self._main)) or REST
        work, kept = dict.fromkeys(STAGES, 0.0), 0.0
        for number, (thread, ran, waited) in now.items():
            _, ran_before, waited_before = before.get(number, (0, 0.0, 0.0))
            work[stage_of(frames.get(thread)) or otherwise] += ran - ran_before
            kept += waited - waited_before
        # Threads that ended in between count as the others.
        seen = sum(work.values())
        work = {stage: seconds * used / seen for stage, seconds in work.items()} if seen else work
        return Moment(passed, work, kept)


def stage_of(frame: FrameType | None) -> str | None:
    """What a thread is at, by the innermost of its functions that belongs to a stage."""
    while frame is not None:
        module = str(frame.f_globals.get("__name__", ""))
        for stage, (_, begins) in STAGES.items():
            if module.startswith(begins) and module != AROUND:
                return stage
        frame = frame.f_back
    return None


def watched(run: Callable[[], object]) -> list[Moment]:
    """The moments of a run; of its second time, when all that is loaded once is."""
    run()
    with Watch() as watch:
        run()
    return watch.moments


def undisturbed(moments: list[Moment]) -> NDArray[np.float64]:
    """``(M,)``: seconds that each would have taken, had other programs left all cores to this one.

    Threads that are at work or wait for a core would have all cores between them. It is seen over some time, since the
    system counts waiting when it ends.
    """
    some = np.ones(min(SOME, len(moments)))
    passed = np.array([moment.seconds for moment in moments])
    time, waited = (np.convolve(values, some, "same") for values in (passed, [moment.waited for moment in moments]))
    used = np.convolve([sum(moment.work.values()) for moment in moments], some, "same")
    share = used / np.maximum(np.minimum(used + waited, cores() * time), 1e-9)
    return np.where(waited > 0, np.minimum(share, 1), 1) * passed


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
