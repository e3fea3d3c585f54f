"""One card an expression: its renders, the worst of them first, with pictures and numbers."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from facezip.documents.document import Data
from reports.images import ColourScale
from reports.metrics import BY_KEY, Metric, floor_text
from reports.pictures import HERO, OTHER, WORST, Pictures, Quality, embed

Render = Data


@dataclass(frozen=True)
class ViewData:
    """What the page's script needs for one render: data URIs by pack, None where they are in the page already."""

    label: str
    exr: str
    original: str | None
    compressed: Sequence[str | None]
    difference: Sequence[str | None]
    floor: Sequence[str]
    numbers: Sequence[Sequence[str]]


@dataclass(frozen=True)
class CardData:
    """All that can be chosen on a card; ``pack`` is the headline pack's index."""

    pack: int
    views: Sequence[ViewData]


@dataclass(frozen=True)
class View:
    """One render of an expression: where it was seen from, its pictures, and the numbers as text."""

    label: str
    exr: str
    pictures: Pictures
    floor: tuple[str, ...]
    numbers: tuple[tuple[str, ...], ...]

    def data(self, shown: int | None = None) -> ViewData:
        """The same; without pictures of pack ``shown``, which are in the page already."""

        def unless_shown(uris: tuple[str, ...]) -> list[str | None]:
            return [None if i == shown else uri for i, uri in enumerate(uris)]

        return ViewData(
            label=self.label,
            exr=self.exr,
            original=None if shown is not None else self.pictures.original,
            compressed=unless_shown(self.pictures.compressed),
            difference=unless_shown(self.pictures.differences),
            floor=self.floor,
            numbers=self.numbers,
        )


@dataclass(frozen=True)
class Card:
    """An expression with its renders; ``views[0]`` is the worst, with the largest image RMSE of the headline pack."""

    expression: str
    anchor: str
    error: str
    pack: int
    views: tuple[View, ...]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the widest picture."""
        return max((view.pictures.size for view in self.views), key=lambda size: size[0] / size[1])

    def data(self) -> Data:
        """What can be chosen; the first render with the headline pack is in the page itself."""
        views = [view.data(None if i else self.pack) for i, view in enumerate(self.views)]
        return asdict(CardData(self.pack, views))


def make_cards(document: Data, folder: Path, pack: int, scale: ColourScale, metrics: Sequence[Metric]) -> list[Card]:
    """The hero, and a card for each expression, worst first by image RMSE of the pack with index ``pack``.

    The hero is the worst render of all, embedded without loss. ``metrics`` are the columns of each card's numbers.
    """
    grouped = _worst_first(document["renders"], pack)
    if not grouped:
        return []
    jobs: list[tuple[Render, Quality]] = [(grouped[0][0], HERO)]
    for renders in grouped:
        jobs += [(render, OTHER if i else WORST) for i, render in enumerate(renders)]
    views = [
        _view(render, pictures, metrics)
        for (render, _), pictures in zip(jobs, embed(jobs, folder, len(document["packs"]), scale), strict=True)
    ]
    cards = [_card(grouped[0][0], pack, views[:1], "hero")]
    start = 1
    for rank, renders in enumerate(grouped, 1):
        cards.append(_card(renders[0], pack, views[start : start + len(renders)], f"expression-{rank}"))
        start += len(renders)
    return cards


def _worst_first(renders: list[Render], pack: int) -> list[list[Render]]:
    def error(render: Render) -> float:
        return float(render["packs"][pack]["image_rmse"] or 0.0)

    names = dict.fromkeys(render["expression"] for render in renders)
    grouped = [
        sorted((render for render in renders if render["expression"] == name), key=error, reverse=True)
        for name in names
    ]
    return sorted(grouped, key=lambda group: error(group[0]), reverse=True)


def _view(render: Render, pictures: Pictures, metrics: Sequence[Metric]) -> View:
    return View(
        label=place(render),
        exr=render["exr"],
        pictures=pictures,
        floor=tuple(floor_text(metric, render) for metric in metrics),
        numbers=tuple(tuple(metric.of(pack) for metric in metrics) for pack in render["packs"]),
    )


def _card(render: Render, pack: int, views: list[View], anchor: str) -> Card:
    error = BY_KEY["image_rmse"].of(render["packs"][pack])
    return Card(render["expression"], anchor, error, pack, tuple(views))


def place(where: Data) -> str:
    """View and light as a person reads them: ``front · studio``."""
    return " · ".join(str(where[key]) for key in ("view", "light") if where.get(key))
