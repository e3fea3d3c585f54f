"""Figure 7, left: how the cost of the stitching falls from random starts, and where it ends."""

from collections.abc import Callable, Sequence

import numpy as np

from reports.metrics import MISSING, number
from reports.paper.documents.figures import ConvergenceFigure
from reports.paper.methods import METHODS
from reports.plots import Axis, Label, Mark, Plot, Point, dashed, dot, line
from reports.tables import Cell, Row, Table

COST = "Stitching cost, squared texel values"
PAPER, OURS = METHODS["paper"].tone, METHODS["paper_optimised"].tone
TOP, BOTTOM, LEFT = 36.0, 330.0, 52.0
MARGIN = 146
GAP = 7.0
Level = tuple[str, float, str, Callable[[Sequence[Point], str], Mark]]


def convergence(figure: ConvergenceFigure, width: float) -> Plot:
    """The cost from every start, sweep by sweep, from zero."""
    right = width - 8
    history = np.array(figure.history)
    sweeps = history.shape[1] - 1
    across = Axis(0, sweeps, LEFT + 6, right, tuple(range(0, sweeps + 1, 2)))
    up = Axis.around([history.max()], BOTTOM, TOP, zero=True)
    paths = [[(across.at(i), up.at(cost)) for i, cost in enumerate(run)] for run in history]
    marks = [line(path, PAPER, width=1, opacity=0.3) for path in paths]
    marks.append(line(paths[history[:, -1].argmin()], PAPER, "the best start", 2.5))
    marks += [draw(((LEFT, up.at(cost)), (right, up.at(cost))), tone) for _, cost, tone, draw in _levels(figure)]
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = f"Cost from {len(history)} random starts"
    return Plot(title, *frame, across.marks(), up.marks(), "Sweep over all masks", COST, tuple(marks))


def ends(figure: ConvergenceFigure, width: float) -> Plot:
    """Where the starts end, magnified, beside what our search finds and what no search can go below."""
    right = width - MARGIN
    final = np.sort(np.array(figure.history)[:, -1])
    levels = _levels(figure)
    up = Axis.around([*final, *(cost for _, cost, _, _ in levels)], BOTTOM, TOP)
    swarm = _swarm([up.at(cost) for cost in final], (LEFT + right) / 2)
    marks = [
        dot(at, "disc", PAPER, f"cost {number(cost, 2)}", 3.5, 0.75) for at, cost in zip(swarm, final, strict=True)
    ]
    marks += [draw(((LEFT, up.at(cost)), (right, up.at(cost))), tone) for _, cost, tone, draw in levels]
    levels = sorted([(f"best of {len(final)}", float(final[0]), PAPER, line), *levels], key=lambda level: -level[1])
    labels = []
    for y, (words, cost, tone, _) in zip(_apart([up.at(cost) for _, cost, _, _ in levels], 17), levels, strict=True):
        marks.append(line(((right, up.at(cost)), (right + 14, y)), tone))
        labels.append(Label(right + 18, round(y + 4, 1), f"{words} {number(cost, 2)}"))
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = "Where the starts end, magnified"
    return Plot(title, *frame, (), up.marks(), "One dot a start", COST, tuple(marks), tuple(labels))


def table(figure: ConvergenceFigure) -> Table:
    """Cost, gap to the lower bound and seconds of every search, and the bound itself."""
    notes = {"paper": f"best of {len(figure.history)} starts", "paper_optimised": "beam search"}
    rows = []
    for key in (key for key in METHODS if key in figure.cost):
        gap = figure.gap[key]
        share = MISSING if gap is None else number(100 * gap, 1)
        values = number(figure.cost[key], 2), share, number(figure.seconds[key], 3)
        rows.append(Row(METHODS[key].label, tuple(map(Cell, values)), notes.get(key, "")))
    known = MISSING if figure.lower_bound is None else number(figure.lower_bound, 2)
    bound = Cell(known), Cell(MISSING), Cell(number(figure.seconds["lower_bound"], 3))
    rows.append(Row("Lower bound", bound, "branch and bound: no permutation costs less"))
    caption = "What each search ends with; the gap is the share of its cost above the lower bound."
    return Table(caption, "Search", ("Cost", "Gap, %", "Time, s"), tuple(rows))


def _levels(figure: ConvergenceFigure) -> list[Level]:
    """Costs that no start is needed for: words, cost, tone, and how the line is drawn."""
    levels: list[Level] = []
    if "paper_optimised" in figure.cost:
        levels.append(("our search", figure.cost["paper_optimised"], OURS, line))
    if figure.lower_bound is not None:
        levels.append(("lower bound", figure.lower_bound, "muted", dashed))
    return levels


def _swarm(heights: Sequence[float], middle: float) -> list[Point]:
    """Dots at the given heights, as near to the middle as they come without touching those placed before."""
    placed: list[Point] = []
    for y in heights:
        near = [x for x, other in placed if abs(other - y) < GAP]
        steps = (middle + side * step * GAP for step in range(len(near) + 1) for side in (1, -1))
        placed.append((next(x for x in steps if all(abs(x - other) >= GAP - 1e-6 for other in near)), y))
    return placed


def _apart(places: Sequence[float], gap: float) -> list[float]:
    """Places from top to bottom, each moved down until it is ``gap`` below the one before."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + gap) if moved else place)
    return moved
