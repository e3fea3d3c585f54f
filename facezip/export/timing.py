"""GPU time: six fetches with their pre-pass against a fetch of every texture, by the device's own timer."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Literal

import numpy as np

from facezip.documents.document import Document
from facezip.export.opengl import Device, devices, opened
from facezip.export.shading import SLOTS, WEIGHT_SCALE, Pass, Shading
from facezip.machine.conditions import Conditions, conditions
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


@dataclass(frozen=True, kw_only=True)
class DeviceFacts:
    """A device that draws.

    Attributes
    ----------
    index : EGL's number.
    fault : why it cannot be used; "" where it can.
    renderer, version : what OpenGL says of it.
    software : whether a processor does the work.
    """

    index: int
    fault: str
    renderer: str
    version: str
    software: bool


@dataclass(frozen=True, kw_only=True)
class MeasuredDevice(DeviceFacts):
    """The device that was measured.

    Attributes
    ----------
    most_textures_of_a_shader : its limit.
    """

    most_textures_of_a_shader: int


@dataclass(frozen=True, kw_only=True)
class BlendTimes:
    """GPU time of one number of expressions, in milliseconds.

    Attributes
    ----------
    expressions : how many.
    prepass_ms, blend_ms, facezip_ms : of the weights, of the blend, and their sum.
    textures_ms, textures_few_ms : of a fetch of every expression's texture, with all at work and with a few.
    ratio, ratio_few : of FaceZip to those.
    fetches : a pixel, of FaceZip.
    bytes, bytes_textures : of texels, of both.
    """

    expressions: int
    prepass_ms: float
    blend_ms: float
    facezip_ms: float
    textures_ms: float
    textures_few_ms: float
    ratio: float
    ratio_few: float
    fetches: int
    bytes: int
    bytes_textures: int


@dataclass(frozen=True, kw_only=True)
class ShaderConditions(Conditions):
    """How times were taken, in words."""

    statistic: str
    timer: str
    textures: str


@dataclass(frozen=True, kw_only=True)
class ShaderDocument(Document):
    """What a blend costs on a GPU.

    Attributes
    ----------
    device, devices : the one that was measured, and all.
    resolution, weight_resolution : sides of textures and weight maps.
    few : how many expressions are a few.
    rows : by number of expressions.
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-shader/1"] = "facezip-bench-shader/1"
    device: MeasuredDevice
    devices: Sequence[DeviceFacts]
    resolution: int
    weight_resolution: int
    few: int
    rows: Sequence[BlendTimes]
    conditions: ShaderConditions


def bench_shader(resolution: int, counts: tuple[int, ...], repeats: int, index: int | None = None) -> ShaderDocument:
    """GPU time of a picture of ``resolution``² pixels, one texel each.

    Parameters
    ----------
    resolution : of textures, a multiple of 8.
    counts : numbers of expressions, one measurement each.
    repeats : of every draw, in turn; medians are given.
    index : of EGL's device; else the first GPU, else software.

    Raises
    ------
    FaceZipError
        ``NO_GPU``: what :mod:`facezip.export.opengl` and :class:`facezip.export.shading.Shading` raise.
    """
    with opened(index) as (device, context):
        queried = not device.is_software
        many = track(counts, "Measuring", len(counts))
        rows = [_measured(context, count, resolution, repeats, queried) for count in many]
        limit = context.info["GL_MAX_TEXTURE_IMAGE_UNITS"]
    return ShaderDocument(
        device=MeasuredDevice(**vars(_said(device)), most_textures_of_a_shader=limit),
        devices=[_said(one) for one in devices()],
        resolution=resolution,
        weight_resolution=resolution // WEIGHT_SCALE,
        few=FEW,
        rows=rows,
        conditions=ShaderConditions(
            **vars(conditions(("facezip", "moderngl"))),
            statistic=f"the median of {repeats}, in turn",
            timer="GL_TIME_ELAPSED" if queried else "the processor's clock, until all is drawn",
            textures="RGBA8, random texels, bilinear, one level, one texel a pixel",
        ),
    )


def _said(device: Device) -> DeviceFacts:
    return DeviceFacts(**vars(device), software=device.is_software)


def _measured(context: "moderngl.Context", count: int, side: int, repeats: int, queried: bool) -> BlendTimes:
    shading = Shading(context, count, side)
    try:
        times = _times(context, shading, count, repeats, queried)
    finally:
        shading.release()
    facezip = times["prepass"] + times["blend"]
    picture = 4 * side * side
    return BlendTimes(
        expressions=count,
        prepass_ms=times["prepass"],
        blend_ms=times["blend"],
        textures_ms=times["textures"],
        textures_few_ms=times["textures_few"],
        facezip_ms=facezip,
        ratio=facezip / times["textures"],
        ratio_few=facezip / times["textures_few"],
        fetches=2 + SLOTS,
        bytes=picture * (1 + SLOTS) + picture * count // WEIGHT_SCALE**2,
        bytes_textures=picture * (1 + count),
    )


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
