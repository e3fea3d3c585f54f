"""Figure 7, right: the error against the number of masks, as box plots over random starts."""

import numpy as np

from reports.metrics import number
from reports.paper.documents.figures import MasksFigure
from reports.paper.methods import METHODS, Method
from reports.plots import Axis, Label, Mark, Plot, bar, dot, line
from reports.tables import Cell, Row, Table

RMSE, MASKS = "RMSE, of 255", "Number of masks"
CHOOSERS = ("paper_optimised", "paper")
PAPER = METHODS["paper"].tone
TOP, BOTTOM, LEFT = 36.0, 330.0, 52.0


def choosers(figure: MasksFigure) -> list[Method]:
    """The searches that choose a permutation, in the report's order."""
    chosen = figure.counts[0].chosen if figure.counts else {}
    return [METHODS[key] for key in CHOOSERS if key in chosen]


def legend(figure: MasksFigure) -> tuple[tuple[Mark, str, str], ...]:
    """The marks of what each search chooses."""
    return tuple((method.mark, f"{method.label}: its choice", "") for method in choosers(figure))


def whole(figure: MasksFigure, width: float) -> Plot:
    """The boxes on a scale from zero, beside the errors of what knows no masks."""
    right = width - 8
    levels = figure.without_masks or {}
    up = Axis.around([*_errors(figure), *levels.values()], BOTTOM, TOP, zero=True)
    across = _across(figure, right)
    marks, labels = _boxes(figure, across, up), []
    for key, value in levels.items():
        words, y = f"{METHODS[key].label} {number(value, 2)}", up.at(value)
        marks.append(line(((LEFT, y), (right, y)), METHODS[key].tone, words, 2))
        labels.append(Label(LEFT + 4, round(y + 17, 1), words))
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = "Error against the number of masks, from zero"
    return Plot(title, *frame, across.marks(), up.marks(), MASKS, RMSE, tuple(marks), tuple(labels))


def magnified(figure: MasksFigure, width: float) -> Plot:
    """The spread over random starts, and what each search chooses."""
    right = width - 8
    chosen = [row.chosen[method.key].rmse for row in figure.counts for method in choosers(figure)]
    up = Axis.around([*_errors(figure), *chosen], BOTTOM, TOP)
    across = _across(figure, right)
    marks = _boxes(figure, across, up)
    for row in figure.counts:
        for method in reversed(choosers(figure)):
            value = row.chosen[method.key].rmse
            words = f"{row.masks} masks · {method.label}: {number(value, 2)}"
            marks.append(dot((across.at(row.masks), up.at(value)), method.shape, method.tone, words))
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = "The same, magnified, with what each search chooses"
    return Plot(title, *frame, across.marks(), up.marks(), MASKS, RMSE, tuple(marks))


def table(figure: MasksFigure) -> Table:
    """The same as numbers."""
    methods = choosers(figure)
    rows = []
    for row in figure.counts:
        values = [*np.percentile(row.rmse, (0, 50, 100)), *(row.chosen[method.key].rmse for method in methods)]
        rows.append(Row(str(row.masks), tuple(Cell(number(value, 2)) for value in values)))
    columns = ("Least", "Median", "Largest", *(f"{method.label}: its choice" for method in methods))
    caption = f"RMSE of 255 of {figure.starts} single starts, and of what each search chooses."
    return Table(caption, "Masks", columns, tuple(rows))


def _errors(figure: MasksFigure) -> list[float]:
    return [value for row in figure.counts for value in row.rmse]


def _across(figure: MasksFigure, right: float) -> Axis:
    counts = tuple(row.masks for row in figure.counts)
    return Axis(0, max(counts) * 1.05, LEFT, right, counts)


def _boxes(figure: MasksFigure, across: Axis, up: Axis) -> list[Mark]:
    """A box from quartile to quartile with the median across, and whiskers from the least to the largest error."""
    counts = [row.masks for row in figure.counts]
    closest = float(min(np.diff(counts), default=max(counts)))
    half = min(10.0, 0.35 * (across.at(closest) - across.at(0)))
    marks = []
    for row in figure.counts:
        low, first, median, third, high = np.percentile(row.rmse, (0, 25, 50, 75, 100))
        x = across.at(row.masks)
        words = f"{row.masks} masks: {low:.2f} to {high:.2f}, median {median:.2f}, {len(row.rmse)} starts"
        marks.append(line(((x, up.at(low)), (x, up.at(high))), PAPER))
        marks += [line(((x - half / 2, up.at(end)), (x + half / 2, up.at(end))), PAPER) for end in (low, high)]
        marks.append(bar(x - half, up.at(third), x + half, up.at(first), PAPER, words))
        marks.append(line(((x - half, up.at(median)), (x + half, up.at(median))), PAPER, words, 2.5))
    return marks
