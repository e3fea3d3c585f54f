"""Figure 8: textures of generated shapes, by the naive sum of differences, by the paper and by ours."""

from facezip.documents.document import Data
from reports.metrics import number
from reports.paper import figure_6
from reports.paper.methods import METHODS
from reports.paper.table_1 import size
from reports.sections import Section, Strip

ANCHOR, SHORT, TITLE = "figure-8", "Figure 8", "Figure 8: textures of generated shapes"
Figure = Data


def section(document: Data) -> Section:
    """The section of the page; words alone where there was no template."""
    figure = document.get("figure_8")
    if figure is None:
        skipped = "Skipped: it takes a template, whose shapes are generated from the scans; add --template FOLDER."
        return Section(ANCHOR, SHORT, TITLE, skipped)
    measured = "rmse" in figure
    return Section(
        ANCHOR,
        SHORT,
        TITLE,
        _intro(figure),
        legend=figure_6.legend(figure) if measured else (),
        plots=((figure_6.upright(figure, "shape"), figure_6.lying(figure, "shape")),) if measured else (),
        strips=tuple(Strip(_title(figure, shape), uri, _words(figure)) for shape, uri in figure["pictures"].items()),
        tables=(figure_6.table(figure, "shape"),) if measured else (),
        folded=True,
    )


def _intro(figure: Figure) -> str:
    condition = f"cond(B) = {number(figure['condition'], 1)}" if figure["condition"] else "B has no inverse"
    against = "RMSE to the truth, 0 to 255. " if "rmse" in figure else "Without a known truth there are no errors. "
    return (
        f"Albedos of a template’s shapes, made for this person by example-based rigging, at "
        f"{size(figure['resolution'])}; {condition}. {against}Pictures, from left to right: {_words(figure)}. "
        f"{len(figure['unseen'])} shapes are hardly in any scan and nearly keep the neutral’s texture. "
        "Ours are made of scans that were cleaned."
    )


def _words(figure: Figure) -> str:
    return ", ".join(METHODS[name].label if name in METHODS else name for name in figure["columns"])


def _title(figure: Figure, shape: str) -> str:
    if "rmse" not in figure:
        return shape
    errors = (number(figure["rmse_per_expression"][name][shape], 2) for name in figure["columns"] if name != "truth")
    return f"{shape}: RMSE {', '.join(errors)}"
