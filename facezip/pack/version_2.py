"""Version 2 of the pack: maps and tiles as in version 3, with other words, implied names, and meshes as OBJ."""

from facezip.files.obj import LONGEST_LINE
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import Fields

FORMAT = "facezip-pack/2"
MESH_FILE, DELTAS_FILE = "neutral.obj", "deltas.f32"

_COUNTS = ("vertices", "triangles", "texture_coordinates")
# What all versions have, and versions 1 and 2 have besides.
COMMON = {"name", "method", "expressions", "uniform_weights", "made_with", "files", *_COUNTS}
_TILE = {"number", "weight_size", "weight_columns", "weight_scale", "weight_offset", "textures"}
_TEXTURE = {"size", "neutral_bits", "difference_scale"}


def as_version_3(document: Fields) -> Fields:
    """The document of a manifest, as version 3 states the same; KeyError, TypeError or ValueError for any other."""
    old = of_fields(document, COMMON | {"maps", "tiles"})
    names = [kind["name"] for kind in old["maps"]]
    tiles = tuple(_tile(of_fields(tile, _TILE), names) for tile in old.pop("tiles"))
    return {**geometry_of(old), "tiles": tiles}


def of_fields(entry: Fields, names: set[str]) -> Fields:
    """A copy, if these are its fields and no others; else ValueError."""
    if odd := {*entry} ^ names:
        raise ValueError(f"field '{min(odd)}' is {'missing' if min(odd) in names else 'unknown'}")
    return dict(entry)


def geometry_of(old: Fields) -> Fields:
    """A document of version 1 or 2, with what it says of meshes as version 3 says it."""
    counts = [old[name] for name in _COUNTS]
    vertices, triangles, _ = counts
    rest = {name: value for name, value in old.items() if name not in _COUNTS}
    if not all(type(count) is int and count >= 0 for count in counts) or len({count > 0 for count in counts}) > 1:
        raise ValueError("its counts of vertices, triangles and texture coordinates are out of range")
    if vertices == 0:
        return {**rest, "geometry": None}
    lines, sizes = sum(counts), {name: entry["bytes"] for name, entry in old["files"].items()}
    if not 4 * lines <= sizes[MESH_FILE] <= LONGEST_LINE * lines:
        raise ValueError(f"'{MESH_FILE}' is out of proportion")
    if sizes[DELTAS_FILE] != 4 * 3 * vertices * len(old["expressions"]):
        raise ValueError(f"'{DELTAS_FILE}' has another size than stated")
    return {**rest, "geometry": {"files": (MESH_FILE, DELTAS_FILE), "vertices": vertices, "triangles": triangles}}


def _tile(old: Fields, names: list[str]) -> Fields:
    number, spans = old["number"], old.pop("weight_scale")
    layers = 0 if old["weight_size"] == (1, 1) else -(-len(spans) // SLOTS_PER_LAYER)
    weights = tuple(f"weights{f'_{layer}' if layer else ''}.{number}.png" for layer in range(layers))
    textures = tuple(
        _texture(of_fields(texture, _TEXTURE), f"{name}.{number}")
        for name, texture in zip(names, old.pop("textures"), strict=True)
    )
    return {**old, "weight_span": spans, "weights": weights, "textures": textures}


def _texture(old: Fields, stem: str) -> Fields:
    spans = old.pop("difference_scale")
    differences = tuple(f"{stem}.difference_{i}.png" for i in range(len(spans)))
    return {**old, "difference_span": spans, "neutral": f"{stem}.neutral.png", "differences": differences}
