"""The sections of the paper's page, one function a section."""

from reports.paper import figure_6, figure_7_left, figure_7_right, figure_8, table_1
from reports.paper.documents.paper import PaperDocument
from reports.paper.table_1 import size
from reports.sections import Section

WIDE, NARROW = 560.0, 380.0


def sections(document: PaperDocument) -> list[Section]:
    """All sections in the order of the page; a further figure is one more function here."""
    makers = (_table_1, _figure_6, _figure_7_left, _figure_7_right, figure_8.section)
    return [make(document) for make in makers]


def _table_1(document: PaperDocument) -> Section:
    conditions = document.conditions
    intro = f"Measured on {conditions.maps}. Texture sizes: {conditions.texture_sizes}."
    tables = table_1.times(document), table_1.memory(document), table_1.errors(document)
    return Section("table-1", "Table 1", "Table 1: time, memory and error", intro, tables=tables)


def _figure_6(document: PaperDocument) -> Section:
    figure, region = document.figure_6, document.conditions.texture_region
    return Section(
        "figure-6",
        "Figure 6",
        "Figure 6: error per expression",
        f"Texture RMSE, 0 to 255, at {size(figure.resolution)}, over {region}. Lower is better.",
        legend=figure_6.legend(figure),
        plots=((figure_6.upright(figure), figure_6.lying(figure)),),
        tables=(figure_6.table(figure),),
        folded=True,
    )


def _figure_7_left(document: PaperDocument) -> Section:
    figure = document.figure_7_convergence
    return Section(
        "figure-7-left",
        "Figure 7 left",
        "Figure 7, left: convergence of the stitching",
        f"Equation (3) with {figure.masks} masks at {size(figure.resolution)}: the paper’s search from "
        f"{len(figure.history)} random permutations, mask after mask. The thick line is the best start.",
        plots=tuple(
            (draw(figure, WIDE), draw(figure, NARROW)) for draw in (figure_7_left.convergence, figure_7_left.ends)
        ),
        tables=(figure_7_left.table(figure),),
    )


def _figure_7_right(document: PaperDocument) -> Section:
    figure = document.figure_7_masks
    return Section(
        "figure-7-right",
        "Figure 7 right",
        "Figure 7, right: error and number of masks",
        f"Mean RMSE at {size(figure.resolution)}. Boxes: {figure.starts} random starts, each taken to its end "
        "alone, from quartile to quartile with the median across; whiskers reach the least and the largest error.",
        legend=figure_7_right.legend(figure),
        plots=tuple(
            (draw(figure, WIDE), draw(figure, NARROW)) for draw in (figure_7_right.whole, figure_7_right.magnified)
        ),
        tables=(figure_7_right.table(figure),),
        folded=True,
    )
