"""The errors of a character's maps, where it has more than an albedo."""

from collections.abc import Mapping, Sequence

from facezip.character.maps import ALBEDO
from facezip.documents.document import Data, from_plain
from facezip.pack.errors import MapErrors
from reports.metrics import MISSING, number
from reports.tables import Cell, Row, Table

Errors = Mapping[str, MapErrors]


def maps_table(packs: Sequence[Data]) -> Table | None:
    """One row a map, one column a pack, in small print the worst expression; None where there is only an albedo."""
    errors = [map_errors(pack.get("map_errors", {})) for pack in packs]
    names = list(dict.fromkeys(name for found in errors for name in found))
    if len(names) < 2:
        return None
    rows = [Row(name, tuple(_cell(found.get(name)) for found in errors), _unit(errors, name)) for name in names]
    caption = "Mean over expressions, inside the mask, of the maps as a pack gives them back; in small print the worst."
    return Table(caption, "Map", tuple(pack["name"] for pack in packs), tuple(rows))


def map_errors(data: Data) -> Errors:
    """The errors by map that a document says as plain data."""
    return from_plain(data, dict[str, MapErrors])


def headline(found: Data) -> float:
    """:attr:`facezip.pack.errors.MapErrors.mean` of plain data."""
    return from_plain(found, MapErrors).mean


def unit(found: Data) -> str:
    """:func:`unit_of` of plain data."""
    return unit_of(from_plain(found, MapErrors))


def unit_of(found: MapErrors) -> str:
    """Of the mean error of a map, as it stands behind its name in a table's head."""
    return "mean angle in degrees" if found.is_angular else "RMSE of 255"


def headlines(errors: Errors) -> str:
    """The number of every map but the albedo in one line: ``normal 0.61°, roughness 0.93``; empty for none."""
    others = {name: found for name, found in errors.items() if name != ALBEDO}
    return ", ".join(f"{name} {number(found.mean, 2)}{'°' * found.is_angular}" for name, found in others.items())


def _unit(errors: Sequence[Errors], name: str) -> str:
    return unit_of(next(found[name] for found in errors if name in found))


def _cell(found: MapErrors | None) -> Cell:
    if found is None:
        return Cell(MISSING)
    each = found.per_expression
    worst = max(each, key=each.__getitem__)
    return Cell(number(found.mean, 2), f"{number(each[worst], 2)} · {worst}")
