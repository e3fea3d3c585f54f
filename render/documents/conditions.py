"""Under which conditions something was rendered."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from scenes.cameras import View


@dataclass(frozen=True, kw_only=True)
class Versions:
    """Of the renderer: Mitsuba's variant, Mitsuba, Dr.Jit and LLVM."""

    variant: str
    mitsuba: str
    drjit: str
    llvm: str


@dataclass(frozen=True, kw_only=True)
class RenderConditions(Versions):
    """How renders were made.

    Attributes
    ----------
    views, lights : cameras, and rigs by name.
    material, transport : what light meets, and how it travels.
    resolution : width and height in pixels.
    spp : samples a pixel to begin with.
    seed : of all random numbers.
    units : of metrics, by name.
    """

    views: Sequence[View]
    lights: Sequence[str]
    material: str
    transport: str
    resolution: int
    spp: int
    seed: int
    units: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class RenderSeconds:
    """Of rendering and measuring, over all processes, and of the whole job."""

    render: float
    metrics: float
    total: float
