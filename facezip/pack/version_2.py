"""Version 2 of the pack: maps and tiles as in version 3, with other words, implied names, and meshes as OBJ."""

from typing import Any

from facezip.files.obj import LONGEST_LINE
from facezip.pack.footprint import SLOTS_PER_LAYER

FORMAT = "facezip-pack/2"
MESH_FILE, DELTAS_FILE = "neutral.obj", "deltas.f32"


def as_version_3(document: dict[str, Any]) -> dict[str, Any]:
    """The document of a manifest, as version 3 states the same; KeyError, TypeError or ValueError for any other."""
    old = dict(document)
    names = [kind["name"] for kind in old["maps"]]
    tiles = tuple(_tile(dict(tile), names) for tile in old.pop("tiles"))
    return {**geometry_of(old), "tiles": tiles}


def _tile(old: dict[str, Any], names: list[str]) -> dict[str, Any]:
    number, spans = old["number"], old.pop("weight_scale")
    layers = 0 if old["weight_size"] == (1, 1) else -(-len(spans) // SLOTS_PER_LAYER)
    textures = tuple(
        _texture(dict(texture), f"{name}.{number}") for name, texture in zip(names, old.pop("textures"), strict=True)
    )
    weights = tuple(f"weights{f'_{layer}' if layer else ''}.{number}.png" for layer in range(layers))
    return {**old, "weight_span": spans, "weights": weights, "textures": textures}


def _texture(old: dict[str, Any], stem: str) -> dict[str, Any]:
    spans = old.pop("difference_scale")
    differences = tuple(f"{stem}.difference_{i}.png" for i in range(len(spans)))
    return {**old, "difference_span": spans, "neutral": f"{stem}.neutral.png", "differences": differences}


def geometry_of(old: dict[str, Any]) -> dict[str, Any]:
    """A document of version 1 or 2, with what it says of meshes as version 3 says it."""
    counts = ("vertices", "triangles", "texture_coordinates")
    vertices, triangles, uvs = (old[name] for name in counts)
    rest = {name: value for name, value in old.items() if name not in counts}
    if not all(
        type(count) is int and count >= 0 and (count > 0) == (vertices > 0) for count in (vertices, triangles, uvs)
    ):
        raise ValueError("its counts of vertices, triangles and texture coordinates are out of range")
    if vertices == 0:
        return {**rest, "geometry": None}
    lines, sizes = vertices + triangles + uvs, {name: entry["bytes"] for name, entry in old["files"].items()}
    if not 4 * lines <= sizes[MESH_FILE] <= LONGEST_LINE * lines:
        raise ValueError(f"'{MESH_FILE}' is out of proportion")
    if sizes[DELTAS_FILE] != 4 * 3 * vertices * len(old["expressions"]):
        raise ValueError(f"'{DELTAS_FILE}' has another size than stated")
    return {**rest, "geometry": {"files": (MESH_FILE, DELTAS_FILE), "vertices": vertices, "triangles": triangles}}
