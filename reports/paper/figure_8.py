"""Figure 8: textures of generated shapes, by the naive sum of differences, by the paper and by ours."""

from math import inf, isfinite

from reports.metrics import number
from reports.paper import figure_6
from reports.paper.documents.figures import ErrorFigure, ShapesFigure
from reports.paper.documents.paper import PaperDocument
from reports.paper.methods import METHODS
from reports.paper.table_1 import size
from reports.sections import Section, Strip

ANCHOR, SHORT, TITLE = "figure-8", "Figure 8", "Figure 8: textures of generated shapes"


def section(document: PaperDocument) -> Section:
    """The section of the page; words alone where there was no template."""
    figure = document.figure_8
    if figure is None:
        skipped = "Skipped: it takes a template, whose shapes are generated from the scans; add --template FOLDER."
        return Section(ANCHOR, SHORT, TITLE, skipped)
    measured = errors_of(figure)
    return Section(
        ANCHOR,
        SHORT,
        TITLE,
        _intro(figure),
        legend=figure_6.legend(measured) if measured else (),
        plots=((figure_6.upright(measured, "shape"), figure_6.lying(measured, "shape")),) if measured else (),
        strips=tuple(
            Strip(_title(figure, measured, shape), uri, _words(figure)) for shape, uri in figure.pictures.items()
        ),
        tables=(figure_6.table(measured, "shape"),) if measured else (),
        folded=True,
    )


def errors_of(figure: ShapesFigure) -> ErrorFigure | None:
    """Its errors, shapes in the place of expressions; None where the truth is not known."""
    if figure.rmse is None or figure.rmse_per_expression is None:
        return None
    return ErrorFigure(resolution=figure.resolution, rmse=figure.rmse, rmse_per_expression=figure.rmse_per_expression)


def _intro(figure: ShapesFigure) -> str:
    # Read back from JSON, what is infinite is None.
    number_of_b = inf if figure.condition is None else figure.condition
    condition = f"cond(B) = {number(number_of_b, 1)}" if isfinite(number_of_b) else "B has no inverse"
    against = "RMSE to the truth, 0 to 255. " if figure.rmse else "Without a known truth there are no errors. "
    return (
        f"Albedos of a template’s shapes, made for this person by example-based rigging, at "
        f"{size(figure.resolution)}; {condition}. {against}Pictures, from left to right: {_words(figure)}. "
        f"{len(figure.unseen)} shapes are hardly in any scan and nearly keep the neutral’s texture. "
        "Ours are made of scans that were cleaned."
    )


def _words(figure: ShapesFigure) -> str:
    return ", ".join(METHODS[name].label if name in METHODS else name for name in figure.columns)


def _title(figure: ShapesFigure, measured: ErrorFigure | None, shape: str) -> str:
    if measured is None:
        return shape
    errors = (number(measured.rmse_per_expression[name][shape], 2) for name in figure.columns if name != "truth")
    return f"{shape}: RMSE {', '.join(errors)}"
