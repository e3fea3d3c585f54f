"""Plots with axes as geometry: every mark is a path; templates draw them as inline SVG in the page's colours."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True)
class Axis:
    """A linear scale from the values ``low..high`` to the positions ``begin..end``, with ticks at round values."""

    low: float
    high: float
    begin: float
    end: float
    ticks: tuple[float, ...]

    @classmethod
    def around(cls, values: Sequence[float], begin: float, end: float, count: int = 5, zero: bool = False) -> "Axis":
        """An axis that holds all values, and zero where asked, and begins and ends at a tick."""
        ticks = round_ticks(min(0.0, *values) if zero else min(values), max(values), count)
        return cls(ticks[0], ticks[-1], begin, end, tuple(ticks))

    def at(self, value: float) -> float:
        """The position of a value."""
        return self.begin + (value - self.low) / (self.high - self.low) * (self.end - self.begin)

    def marks(self) -> tuple[tuple[float, str], ...]:
        """Position and text of every tick, all with the same decimals."""
        digits = next((n for n in range(9) if all(round(tick, n) == tick for tick in self.ticks)), 9)
        return tuple((round(self.at(tick), 2), f"{tick:.{digits}f}") for tick in self.ticks)


def round_ticks(low: float, high: float, count: int = 5) -> list[float]:
    """About ``count`` steps of 1, 2, 2.5 or 5 times a power of ten, from ``low`` or below to ``high`` or above."""
    # Values that differ by rounding alone are one value.
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        low, high = low - 0.5 * (abs(low) or 1), high + 0.5 * (abs(high) or 1)
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1, 2, 2.5, 5, 10) if factor * power >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [round(i * step, 12) for i in range(first, last + 1)]


@dataclass(frozen=True)
class Mark:
    """A path in the colour ``tone``: filled, hollow or a line, and the words of its tooltip."""

    path: str
    tone: str
    kind: str = "line"
    width: float = 1.5
    opacity: float = 1.0
    title: str = ""


@dataclass(frozen=True)
class Label:
    """Words in a plot, turned by ``turn`` degrees."""

    x: float
    y: float
    text: str
    anchor: str = "start"
    turn: float = 0


@dataclass(frozen=True)
class Plot:
    """Marks and labels in a frame ``left..right`` x ``top..bottom``; ticks are (position, text).

    ``title`` and the names of both axes, with their units, are for a person; the template sets them.
    """

    title: str
    width: float
    height: float
    left: float
    right: float
    top: float
    bottom: float
    x_ticks: tuple[tuple[float, str], ...]
    y_ticks: tuple[tuple[float, str], ...]
    x_name: str
    y_name: str
    marks: tuple[Mark, ...]
    labels: tuple[Label, ...] = ()


def line(points: Sequence[Point], tone: str, title: str = "", width: float = 1.5, opacity: float = 1.0) -> Mark:
    """Straight lines from point to point."""
    return Mark(_through(points), tone, "line", width, opacity, title)


def dashed(points: Sequence[Point], tone: str, title: str = "") -> Mark:
    """Dashed lines from point to point."""
    return Mark(_through(points), tone, "dashed", 1.5, 1.0, title)


def dot(at: Point, shape: str, tone: str, title: str = "", radius: float = 4.5, opacity: float = 1.0) -> Mark:
    """A disc, square, diamond or triangle about a point, hollow where the shape's name begins with ``open-``."""
    kind = "hollow" if shape.startswith("open-") else "filled"
    return Mark(_outline(at, shape.removeprefix("open-"), radius), tone, kind, 1.6, opacity, title)


def bar(left: float, top: float, right: float, bottom: float, tone: str, title: str = "") -> Mark:
    """A hollow rectangle."""
    return Mark(f"M{left:.1f} {top:.1f}H{right:.1f}V{bottom:.1f}H{left:.1f}Z", tone, "hollow", 1.5, 1.0, title)


def _through(points: Sequence[Point]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _outline(at: Point, shape: str, radius: float) -> str:
    x, y = at
    if shape == "disc":
        arc = f"a{radius} {radius} 0 1 0"
        return f"M{x - radius:.1f} {y:.1f}{arc} {2 * radius} 0{arc} {-2 * radius} 0Z"
    # Radii that make the areas of all shapes alike.
    corners, turn, grow = {"square": (4, 45, 1.25), "diamond": (4, 0, 1.25), "triangle": (3, -90, 1.4)}[shape]
    angles = [math.radians(turn + i * 360 / corners) for i in range(corners)]
    spots = [(x + grow * radius * math.cos(a), y + grow * radius * math.sin(a)) for a in angles]
    return _through(spots) + "Z"
