"""The errors of a character's maps, where it has more than an albedo."""

from collections.abc import Mapping, Sequence

from facezip.character.maps import ALBEDO
from facezip.documents.document import Data
from reports.metrics import MISSING, number
from reports.tables import Cell, Row, Table


def maps_table(packs: Sequence[Data]) -> Table | None:
    """One row a map, one column a pack, in small print the worst expression; None where there is only an albedo."""
    names = list(dict.fromkeys(name for pack in packs for name in pack.get("map_errors", {})))
    if len(names) < 2:
        return None
    rows = [Row(name, tuple(_cell(pack, name) for pack in packs), _unit(packs, name)) for name in names]
    caption = "Mean over expressions, inside the mask, of the maps as a pack gives them back; in small print the worst."
    return Table(caption, "Map", tuple(pack["name"] for pack in packs), tuple(rows))


def headline(found: Data) -> float:
    """The number of a map's error: the mean angle in degrees of normals, else RMSE of 255."""
    return float(found["angular_error"] if "angular_error" in found else found["rmse"])


def unit(found: Data) -> str:
    """Of :func:`headline`, as it stands behind the name of a map in a table's head."""
    return "mean angle in degrees" if "angular_error" in found else "RMSE of 255"


def headlines(errors: Mapping[str, Data]) -> str:
    """The number of every map but the albedo in one line: ``normal 0.61°, roughness 0.93``; empty for none."""
    others = {name: found for name, found in errors.items() if name != ALBEDO}
    degree = {name: "°" * ("angular_error" in found) for name, found in others.items()}
    return ", ".join(f"{name} {number(headline(found), 2)}{degree[name]}" for name, found in others.items())


def _unit(packs: Sequence[Data], name: str) -> str:
    return unit(next(pack["map_errors"][name] for pack in packs if name in pack.get("map_errors", {})))


def _cell(pack: Data, name: str) -> Cell:
    found = pack.get("map_errors", {}).get(name)
    if found is None:
        return Cell(MISSING)
    each = found["angular_error_per_expression" if "angular_error" in found else "rmse_per_expression"]
    worst = max(each, key=each.__getitem__)
    return Cell(number(headline(found), 2), f"{number(each[worst], 2)} · {worst}")
