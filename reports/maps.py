"""The errors of a character's maps, where it has more than an albedo."""

from collections.abc import Mapping, Sequence
from typing import Any

from reports.metrics import MISSING, number
from reports.tables import Cell, Row, Table


def maps_table(packs: Sequence[Mapping[str, Any]]) -> Table | None:
    """One row a map, one column a pack, in small print the worst expression; None where there is only an albedo."""
    names = list(dict.fromkeys(name for pack in packs for name in pack.get("map_errors", {})))
    if len(names) < 2:
        return None
    rows = [Row(name, tuple(_cell(pack, name) for pack in packs), _unit(packs, name)) for name in names]
    caption = "Mean over expressions, inside the mask, of the maps as a pack gives them back; in small print the worst."
    return Table(caption, "Map", tuple(pack["name"] for pack in packs), tuple(rows))


def _unit(packs: Sequence[Mapping[str, Any]], name: str) -> str:
    angular = any("angular_error" in pack.get("map_errors", {}).get(name, {}) for pack in packs)
    return "mean angle in degrees" if angular else "RMSE of 255"


def _cell(pack: Mapping[str, Any], name: str) -> Cell:
    found = pack.get("map_errors", {}).get(name)
    if found is None:
        return Cell(MISSING)
    key = "angular_error" if "angular_error" in found else "rmse"
    each = found[f"{key}_per_expression"]
    worst = max(each, key=each.__getitem__)
    return Cell(number(found[key], 2), f"{number(each[worst], 2)} · {worst}")
