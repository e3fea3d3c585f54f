"""Where on the face a pack differs: the worst place magnified, and the worst of every region."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from facezip.documents.document import Data
from render.exr import read_exr
from reports.cards import place
from reports.images import ColourScale, data_uri, difference, display, to_bytes
from reports.metrics import BY_KEY
from reports.tables import Cell, Row, Table


@dataclass(frozen=True)
class Place:
    """The worst place of a pack: what it is, and its pictures as data URIs."""

    pack: str
    level: str
    region: str
    label: str
    error: str
    original: str
    compressed: str
    difference: str


def worst_places(packs: Sequence[Data], folder: Path, scale: ColourScale) -> list[Place]:
    """One place a pack, of those that differ anywhere; raises what :func:`render.exr.read_exr` raises."""
    return [_place(k, pack, folder, scale) for k, pack in enumerate(packs) if pack.get("worst_place")]


def _place(k: int, pack: Data, folder: Path, scale: ColourScale) -> Place:
    found = pack["worst_place"]
    top, left, height, width = found["box"]
    parts = [part[top : top + height, left : left + width] for part in read_exr(folder / found["exr"]).values()]
    original, compressed = display(parts[0]), display(parts[k + 1])
    return Place(
        pack=pack["name"],
        level=pack["level"],
        region=found["region"],
        label=f"{found['expression']} · {place(found)}",
        error=BY_KEY["delta_e_p95"].text(found["delta_e_p95"]),
        original=data_uri(to_bytes(original)),
        compressed=data_uri(to_bytes(compressed)),
        difference=data_uri(scale.colours(difference(original, compressed))),
    )


def region_table(packs: Sequence[Data]) -> Table | None:
    """Regions by packs: the worst render of each, the first pack's worst region first; None where none was measured."""
    regions = dict.fromkeys(name for pack in packs for name in pack.get("regions", {}))
    if not regions:
        return None
    rows = tuple(Row(name, tuple(_cell(pack["regions"].get(name)) for pack in packs)) for name in regions)
    caption = "95th percentile of ΔE2000 in each region, in the render in which it is worst; in small print which."
    return Table(caption, "Region", tuple(pack["name"] for pack in packs), rows)


def _cell(worst: Data | None) -> Cell:
    if worst is None:
        return Cell("–", "not seen")
    return Cell(BY_KEY["delta_e_p95"].text(worst["value"]), f"{worst['expression']} · {place(worst)}")


def limits_of(conditions: Data) -> list[tuple[str, str]]:
    """The levels of the verdict and what each means in numbers, for a document that states its limits."""
    limits = conditions.get("thresholds")
    if not limits:
        return []
    low, high = (
        "ΔE2000 p95 ≤ {delta_e:g}, in the worst place ≤ {local:g}, FLIP ≤ {flip:g}".format(**limits[level])
        for level in ("indistinguishable", "visible")
    )
    return [("indistinguishable", low), ("visible", high), ("fails", "beyond")]


def tally(pack: Data) -> str:
    """How many renders have which level, and whether noise left any of them open."""
    counts = ", ".join(f"{count} {level}" for level, count in pack.get("levels", {}).items())
    doubt = "" if pack.get("decided", True) else "; some too close to a limit to tell"
    return f"Renders: {counts}{doubt}" if counts else ""
