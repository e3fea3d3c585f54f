"""A part of a page about experiments: a legend, plots, tables and what there is to say about them."""

from dataclasses import dataclass

from reports.plots import Mark, Plot
from reports.tables import Table


@dataclass(frozen=True)
class Strip:
    """Pictures side by side as one image: its title, a data URI, and what it shows, from left to right."""

    title: str
    uri: str
    words: str


@dataclass(frozen=True)
class Section:
    """One table or figure.

    Attributes
    ----------
    anchor, short : its address in the page and its name in the page's navigation.
    title, intro : heading, and the sentences under it.
    legend : mark, label and note of every method shown.
    plots : pairs of a plot for a wide page and for a telephone; each page shows one of them.
    strips : pictures.
    tables : shown, or behind a click where ``folded``.
    """

    anchor: str
    short: str
    title: str
    intro: str
    legend: tuple[tuple[Mark, str, str], ...] = ()
    plots: tuple[tuple[Plot, Plot], ...] = ()
    strips: tuple[Strip, ...] = ()
    tables: tuple[Table, ...] = ()
    folded: bool = False
