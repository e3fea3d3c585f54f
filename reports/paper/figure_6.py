"""Figure 6: the error of every expression and method, as marks on one scale and as numbers."""

from collections.abc import Mapping, Sequence

from reports.metrics import number
from reports.paper.documents.figures import ErrorFigure
from reports.paper.methods import METHODS, Method
from reports.plots import Axis, Label, Mark, Plot, Point, dot, line
from reports.tables import Cell, Row, Table

RMSE = "RMSE, of 255"
LONGEST_NAME, LONGEST_LYING = 18, 44


def methods_of(figure: ErrorFigure) -> list[Method]:
    """The methods that the figure has, in the report's order."""
    return [method for method in METHODS.values() if method.key in figure.rmse]


def legend(figure: ErrorFigure) -> tuple[tuple[Mark, str, str], ...]:
    """Mark, label and mean of every method."""
    return tuple(
        (method.mark, method.label, f"mean {number(figure.rmse[method.key], 2)}") for method in methods_of(figure)
    )


def upright(figure: ErrorFigure, noun: str = "expression") -> Plot:
    """Expressions from left to right: for wide pages."""
    names = _worst_first(figure)
    left, right, top, bottom = 52.0, 1200.0, 36.0, 380.0
    axis = Axis.around(_values(figure), bottom, top, 7, zero=True)
    slot = (right - left) / len(names)
    marks, labels = [], []
    for i, name in enumerate(names):
        x = left + (i + 0.5) * slot
        marks += _marks(figure, name, [(x, axis.at(value)) for value in _errors(figure, name)])
        labels.append(Label(round(x + 4, 1), bottom + 18, _short(name, LONGEST_NAME), "end", -38))
    room = 24 + 4.6 * max(len(label.text) for label in labels)
    frame = (1200.0, round(bottom + room, 1), left, right, top, bottom)
    title = f"Error of every {noun}, the paper’s worst on the left"
    return Plot(title, *frame, (), axis.marks(), "", RMSE, tuple(marks), tuple(labels))


def lying(figure: ErrorFigure, noun: str = "expression") -> Plot:
    """Expressions from top to bottom: for telephones."""
    names = _worst_first(figure)
    left, right, top, slot = 8.0, 368.0, 44.0, 38.0
    bottom = top + slot * len(names) + 4
    axis = Axis.around(_values(figure), left, right, 4, zero=True)
    marks, labels = [], []
    for i, name in enumerate(names):
        y = top + (i + 0.75) * slot
        marks += _marks(figure, name, [(axis.at(value), y) for value in _errors(figure, name)])
        labels.append(Label(left + 4, round(y - 12, 1), _short(name, LONGEST_LYING)))
    frame = (380.0, bottom + 6, left, right, top, bottom)
    title = f"Error of every {noun}, the paper’s worst on top"
    return Plot(title, *frame, axis.marks(), (), RMSE, "", tuple(marks), tuple(labels))


def table(figure: ErrorFigure, noun: str = "expression") -> Table:
    """The same as numbers, and the means."""
    methods = methods_of(figure)
    rows = []
    for name in _worst_first(figure):
        values = _errors(figure, name)
        rows.append(Row(name, tuple(Cell(number(value, 2), best=value == min(values)) for value in values)))
    rows.append(Row("mean", tuple(Cell(number(figure.rmse[method.key], 2)) for method in methods), strong=True))
    return Table(f"RMSE of 255, per {noun}.", noun.capitalize(), tuple(method.label for method in methods), tuple(rows))


def _marks(figure: ErrorFigure, name: str, places: Sequence[Point]) -> list[Mark]:
    """All methods on one expression, joined by a thin line from the best to the worst; ours on top."""
    dots = [
        dot(place, method.shape, method.tone, f"{name} · {method.label}: {number(value, 2)}")
        for method, place, value in zip(methods_of(figure), places, _errors(figure, name), strict=True)
    ]
    return [line([min(places), max(places)], "line", width=1), *reversed(dots)]


def _errors(figure: ErrorFigure, name: str) -> list[float]:
    """The error of every method on one expression, in the order of :func:`methods_of`."""
    return [figure.rmse_per_expression[method.key][name] for method in methods_of(figure)]


def _worst_first(figure: ErrorFigure) -> list[str]:
    errors: Mapping[str, float] = figure.rmse_per_expression["paper"]
    return sorted(errors, key=lambda name: -errors[name])


def _values(figure: ErrorFigure) -> list[float]:
    return [value for errors in figure.rmse_per_expression.values() for value in errors.values()]


def _short(name: str, longest: int) -> str:
    return name if len(name) <= longest else f"{name[: longest - 1]}…"
