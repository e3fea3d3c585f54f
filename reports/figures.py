"""Charts as geometry; templates draw them as inline SVG that follows the page's colours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from reports.plots import round_ticks

TICKS = 5
LONGEST_NAME = 18
GAP = 0.8


@dataclass(frozen=True)
class Series:
    """One method: a value per group, drawn in the colour class ``tone``."""

    name: str
    values: Mapping[str, float]
    summary: str
    tone: str


@dataclass(frozen=True)
class Bar:
    """A rectangle in the chart's units, and the words of its tooltip."""

    x: float
    y: float
    width: float
    height: float
    tone: str
    title: str


@dataclass(frozen=True)
class BarChart:
    """Grouped bars in a box of ``width`` x ``height``; ticks and labels are (position, text)."""

    width: float
    height: float
    left: float
    right: float
    top: float
    bottom: float
    upright: bool
    bars: tuple[Bar, ...]
    ticks: tuple[tuple[float, str], ...]
    labels: tuple[tuple[float, str], ...]


def nice_ticks(largest: float, count: int = TICKS) -> list[float]:
    """Round numbers from 0 to at or above ``largest``, in about ``count`` steps; 0 and 1 where nothing is above 0."""
    return round_ticks(0.0, largest, count) if largest > 0 else [0.0, 1.0]


def upright_bars(groups: Sequence[str], series: Sequence[Series], width: float = 1200) -> BarChart:
    """Bars that stand, groups from left to right: for wide pages."""
    left, right, top, bottom = 60.0, width, 12.0, 292.0
    ticks = nice_ticks(_largest(groups, series))
    scale = (bottom - top) / ticks[-1]
    slot = (right - left) / max(len(groups), 1)
    thick = min(slot * 0.8 / max(len(series), 1), 22)
    bars, labels = [], []
    for i, group in enumerate(groups):
        start = left + (i + 0.5) * slot - thick * len(series) / 2
        labels.append((left + (i + 0.5) * slot, group))
        for j, one in enumerate(series):
            size = one.values.get(group, 0.0) * scale
            bars.append(_bar(start + j * thick, bottom - size, thick - GAP, size, one, group))
    marks = tuple((bottom - tick * scale, f"{tick:g}") for tick in ticks)
    room = 26 + 4.6 * min(max(map(len, groups), default=0), LONGEST_NAME)
    return BarChart(width, round(bottom + room, 1), left, right, top, bottom, True, tuple(bars), marks, tuple(labels))


def lying_bars(groups: Sequence[str], series: Sequence[Series], width: float = 380) -> BarChart:
    """Bars that lie, groups from top to bottom: for telephones."""
    left, right, top, thick, gap = 4.0, width - 8, 20.0, 7.0, 26.0
    ticks = nice_ticks(_largest(groups, series), 4)
    scale = (right - left) / ticks[-1]
    bars, labels = [], []
    for i, group in enumerate(groups):
        start = top + i * (thick * len(series) + gap) + gap - 6
        labels.append((start - 6, group))
        for j, one in enumerate(series):
            bars.append(_bar(left, start + j * thick, one.values.get(group, 0.0) * scale, thick - GAP, one, group))
    bottom = top + len(groups) * (thick * len(series) + gap)
    marks = tuple((left + tick * scale, f"{tick:g}") for tick in ticks)
    return BarChart(width, bottom + 6, left, right, top, bottom, False, tuple(bars), marks, tuple(labels))


def _bar(x: float, y: float, width: float, height: float, series: Series, group: str) -> Bar:
    value = f"{series.values[group]:.2f}" if group in series.values else "not measured"
    title = f"{group} · {series.name}: {value}"
    return Bar(round(x, 2), round(y, 2), round(width, 2), round(height, 2), series.tone, title)


def _largest(groups: Sequence[str], series: Sequence[Series]) -> float:
    return max((one.values.get(group, 0.0) for one in series for group in groups), default=0.0)
