"""GPU time: six fetches with their pre-pass against a fetch of every texture, by the device's own timer."""

from itertools import pairwise
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from facezip.export.opengl import devices, opened
from facezip.export.shading import SLOTS, WEIGHT_SCALE, Pass, Shading
from facezip.machine.conditions import conditions
from facezip.machine.progress import track

if TYPE_CHECKING:
    import moderngl

# Expressions at work at once in a blend of a few, as faces mostly are.
FEW = 4
# A query counts nanoseconds in 31 bits, and what takes longer is drawn in parts of the picture.
LONGEST_S = 0.5
# Shorter ones are repeated within a query.
SHORTEST_S = 0.005
# For a GPU to leave its idle clocks.
WARM_S = 0.3
MOST_FRAMES = 2000


def bench_shader(resolution: int, counts: tuple[int, ...], repeats: int, index: int | None = None) -> dict[str, Any]:
    """GPU time of a picture of ``resolution``² pixels, one texel each.

    Parameters
    ----------
    resolution : of textures, a multiple of 8.
    counts : numbers of expressions, one measurement each.
    repeats : of every draw, in turn; medians are given.
    index : of EGL's device; else the first GPU, else software.

    Returns
    -------
    ``device`` (its ``software`` says whether a processor did the work), all ``devices``, and of each number of
    expressions ``rows`` in milliseconds: ``prepass_ms``, ``blend_ms``, their sum ``facezip_ms``; ``textures_ms`` with
    all expressions at work and ``textures_few_ms`` with :data:`FEW`; ``ratio`` and ``ratio_few`` to those; and the
    texels' bytes of both.

    Raises
    ------
    FaceZipError
        ``NO_GPU``: what :mod:`facezip.export.opengl` and :class:`facezip.export.shading.Shading` raise.
    """
    with opened(index) as (device, context):
        queried = not device.is_software
        many = track(counts, "Measuring", len(counts))
        rows = [_measured(context, count, resolution, repeats, queried) for count in many]
        limits = {"most_textures_of_a_shader": context.info["GL_MAX_TEXTURE_IMAGE_UNITS"]}
    return {
        "device": _said(device) | limits,
        "devices": [_said(one) for one in devices()],
        "resolution": resolution,
        "weight_resolution": resolution // WEIGHT_SCALE,
        "few": FEW,
        "rows": rows,
        "conditions": {
            **conditions(("facezip", "moderngl")),
            "statistic": f"the median of {repeats}, in turn",
            "timer": "GL_TIME_ELAPSED" if queried else "the processor's clock, until all is drawn",
            "textures": "RGBA8, random texels, bilinear, one level, one texel a pixel",
        },
    }


def _said(device: Any) -> dict[str, Any]:
    return {**vars(device), "software": device.is_software}


def _measured(context: "moderngl.Context", count: int, side: int, repeats: int, queried: bool) -> dict[str, Any]:
    shading = Shading(context, count, side)
    try:
        times = _times(context, shading, count, repeats, queried)
    finally:
        shading.release()
    facezip = times["prepass"] + times["blend"]
    picture = 4 * side * side
    return {
        "expressions": count,
        **{f"{name}_ms": value for name, value in times.items()},
        "facezip_ms": facezip,
        "ratio": facezip / times["textures"],
        "ratio_few": facezip / times["textures_few"],
        "fetches": 2 + SLOTS,
        "bytes": picture * (1 + SLOTS) + picture * count // WEIGHT_SCALE**2,
        "bytes_textures": picture * (1 + count),
    }


def _times(context: "moderngl.Context", shading: Shading, count: int, repeats: int, queried: bool) -> dict[str, float]:
    """Medians in milliseconds by name."""
    every, few = np.full(count, 1 / count, np.float32), np.zeros(count, np.float32)
    few[:: max(1, count // FEW)][:FEW] = 1 / FEW
    passes = shading.passes()
    jobs = {name: (one, every) for name, one in passes.items()} | {"textures_few": (passes["textures"], few)}
    clocks = {}
    for name, (one, weights) in jobs.items():
        shading.show(weights)
        clocks[name] = Clock(context, one, queried)
    found: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(repeats):
        for name, (_, weights) in jobs.items():
            shading.show(weights)
            found[name].append(1e3 * clocks[name].seconds())
    return {name: median(values) for name, values in found.items()}


class Clock:
    """The time of a pass.

    Parameters
    ----------
    context, one : what draws.
    queried : whether by the device's own timer. That of Mesa's software counts a small part of the work alone.
    """

    def __init__(self, context: "moderngl.Context", one: Pass, queried: bool) -> None:
        self._context, self._pass, self._queried = context, one, queried
        once = self._wall()
        begin, frames = perf_counter(), 0
        while perf_counter() - begin < WARM_S and frames < MOST_FRAMES:
            once = min(once, self._wall())
            frames += 1
        self._parts = min(one.rows, int(once / LONGEST_S) + 1) if queried else 1
        self._frames = max(1, min(MOST_FRAMES, int(SHORTEST_S / once)))

    def seconds(self) -> float:
        """Of one picture."""
        if not self._queried:
            return self._wall(self._frames)
        edges = [self._pass.rows * part // self._parts for part in range(self._parts + 1)]
        return sum(self._part(*span) for span in pairwise(edges)) / self._frames

    def _wall(self, frames: int = 1) -> float:
        begin = perf_counter()
        for _ in range(frames):
            self._pass.draw(0, self._pass.rows)
        self._context.finish()
        return (perf_counter() - begin) / frames

    def _part(self, first: int, last: int) -> float:
        query = self._context.query(time=True)
        with query:
            for _ in range(self._frames):
                self._pass.draw(first, last)
        return query.elapsed / 1e9
