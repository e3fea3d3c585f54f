"""The report of ``facezip validate``: verdict first, worst expression first, every number with its conditions."""

from pathlib import Path

from facezip.documents.document import Data, plain, to_json
from facezip.files.writing import write_whole
from render.documents.validation import ValidationDocument
from reports.cards import Card, make_cards
from reports.conditions import condition_rows, glossary
from reports.images import ColourScale
from reports.maps import maps_table
from reports.metrics import IMAGE_METRICS, measured
from reports.page import write_page
from reports.pictures import HERO, OTHER, WORST
from reports.places import Place, limits_of, region_table, tally, worst_places
from reports.summary import comparison_table, distinctly_named, error_bars, headline, memory_table, tiles

PAGE, DATA = "index.html", "report.json"


def write_validation_report(document: ValidationDocument, folder: Path) -> Path:
    """Write ``report.json`` and the page ``index.html`` that shows the same numbers and the renders.

    Parameters
    ----------
    document : what :func:`render.validation.validate` returned; optional ``baselines`` and ``command``.
    folder : where the document's EXR files are, and where both files go, each whole or not at all.

    Returns
    -------
    The path of the page.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` or ``UNREADABLE_IMAGE`` for a render, ``CANNOT_WRITE`` for the output.
    """
    data, text = plain(document), to_json(document)
    data["packs"] = distinctly_named(data["packs"])
    scale = ColourScale.for_error(_largest_error(data))
    pack = headline(data["packs"])
    columns = measured(IMAGE_METRICS, (numbers for render in data["renders"] for numbers in render["packs"]))
    cards = make_cards(data, folder, pack, scale, columns)
    places = worst_places(data["packs"], folder, scale)
    write_whole(folder / DATA, text.encode())
    return write_page(folder / PAGE, "validation.html", **_context(data, pack, cards, places, scale), columns=columns)


def _context(data: Data, pack: int, cards: list[Card], places: list[Place], scale: ColourScale) -> dict[str, object]:
    packs = data["packs"]
    return {
        "document": data,
        "title": f"{data['character']['name']} – FaceZip validation",
        "best": packs[pack],
        "pack": pack,
        "tiles": tiles(packs[pack]),
        "tallies": [tally(entry) for entry in packs],
        "places": places,
        "regions": region_table(packs),
        "limits": limits_of(data["conditions"]),
        "hero": cards[0] if cards else None,
        "cards": cards[1:],
        "aspect": max((card.size[0] / card.size[1] for card in cards), default=1.0),
        "comparison_table": comparison_table(packs),
        "maps": maps_table(packs),
        "chart": error_bars(data, [card.expression for card in cards[1:]]),
        "memory": memory_table(data),
        "conditions": condition_rows(data),
        "glossary": glossary(data),
        "scale": scale,
        "qualities": {"hero": HERO, "worst": WORST, "other": OTHER},
    }


def _largest_error(data: Data) -> float:
    return max((pack["image_rmse"] or 0.0 for render in data["renders"] for pack in render["packs"]), default=0.0)
