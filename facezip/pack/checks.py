"""The range of every field of a manifest: what a reader refuses before it opens another file (docs/pack-format.md)."""

import math
import re
from collections.abc import Iterator
from typing import Any

from facezip.character.maps import ENCODINGS, MAX_RANGE, is_map_name
from facezip.character.scans import MAX_EXPRESSIONS
from facezip.character.tiles import FIRST_TILE, LAST_TILE
from facezip.files.opening import MAX_SIDE
from facezip.files.packs import MANIFEST
from facezip.files.reading import MOST_EXPANSION, SPARE
from facezip.names import MAX_CHARACTERS, first_unusable
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import GeometryEntry, Manifest, MapEntry, MasksEntry, TextureEntry, TileEntry

MAX_DIFFERENCES = 8
MAX_MAPS = 16
MAX_TILES = 100
MAX_MASKS = 4096
# An atlas of many weight maps is larger than a texture may be.
MAX_ATLAS_SIDE = 2**16
MAX_CORNERS = 2**24
MAX_NUMBER = 1e9
BYTES_OF_AN_ACTIVATION = 2

SHA256 = re.compile(r"[0-9a-f]{64}")

Checks = Iterator[tuple[str, bool]]


def first_out_of_range(manifest: Manifest) -> str | None:
    """The name of the first field that is outside its range, None where all are inside."""
    return next((name for name, passed in _checks(manifest) if not passed), None)


def atlas_shape(tile: TileEntry, count: int) -> tuple[int, int, int]:
    """Rows, columns and channels of the image that holds ``count`` weight maps in four slots, or masks by four."""
    h, w = tile.weight_size
    return -(-count // tile.weight_columns) * h, tile.weight_columns * w, SLOTS_PER_LAYER


# Lazily: each check may rely on those before it.
def _checks(m: Manifest) -> Checks:
    yield "name", isinstance(m.name, str) and len(m.name) <= MAX_CHARACTERS and m.name.isprintable()
    yield "method", isinstance(m.method, str) and 0 < len(m.method) <= MAX_CHARACTERS and m.method.isprintable()
    yield "expressions", is_list(m.expressions, 1, MAX_EXPRESSIONS) and are_names(m.expressions)
    yield "made_with", isinstance(m.made_with, dict)
    yield "maps", is_list(m.maps, 1, MAX_MAPS)
    for kind in m.maps:
        yield from _map_checks(kind)
    names = [kind.name for kind in m.maps]
    yield "maps", len({*names}) == len(names)
    yield "tiles", is_list(m.tiles, 1, MAX_TILES)
    for tile in m.tiles:
        yield "number", is_count(tile.number, FIRST_TILE, LAST_TILE)
    numbers = [tile.number for tile in m.tiles]
    yield "number", numbers == sorted({*numbers})
    yield "weight_span", is_list(m.tiles[0].weight_span, 1, MAX_DIFFERENCES)
    slots, count = len(m.tiles[0].weight_span), len(m.expressions)
    if m.masks is not None:
        yield from _mask_checks(m.masks, m)
    for tile in m.tiles:
        yield from _tile_checks(tile, m, slots)
    uniform = [tile.weight_size == (1, 1) for tile in m.tiles]
    yield "weight_size", (all(uniform) and m.masks is None) or not any(uniform)
    rows = count if uniform[0] else 0
    yield "uniform_weights", is_table(m.uniform_weights, (rows, rows), slots, -MAX_NUMBER)
    if m.geometry is not None:
        yield from _geometry_checks(m.geometry)
    yield from _file_checks(m)
    yield from _proportions(m)


def _map_checks(kind: MapEntry) -> Checks:
    yield "maps", is_map_name(kind.name)
    yield "encoding", isinstance(kind.encoding, str) and kind.encoding in ENCODINGS
    yield "range", are_numbers(kind.range, 2, -MAX_RANGE) and kind.range[0] < kind.range[1] <= MAX_RANGE
    yield "range", kind.encoding != "normal" or kind.range == (-1, 1)
    yield "channels", is_count(kind.channels, 1, 4) and (kind.encoding != "normal" or kind.channels == 2)


def _mask_checks(masks: MasksEntry, m: Manifest) -> Checks:
    yield "masks", is_list(masks.names, 1, MAX_MASKS) and are_names(masks.names)
    yield "masks", is_list(masks.files, len(m.tiles), len(m.tiles)) and type(masks.clamped) is bool
    for tile in m.tiles:
        # As they are: masks have their own range, and activations theirs.
        yield "weight_span", tile.weight_span == (1,) * len(m.tiles[0].weight_span)
        yield "weight_offset", tile.weight_offset == (0,) * len(tile.weight_span)


def _tile_checks(tile: TileEntry, m: Manifest, slots: int) -> Checks:
    maps, count = m.maps, m.masks.fours if m.masks else len(m.expressions)
    yield "weight_size", is_size(tile.weight_size)
    yield "weight_columns", is_count(tile.weight_columns, 1, count)
    yield "weight_columns", max(atlas_shape(tile, count)) <= MAX_ATLAS_SIDE
    yield "weight_span", are_numbers(tile.weight_span, slots, 0)
    yield "weight_offset", are_numbers(tile.weight_offset, slots, -MAX_NUMBER)
    layers = 0 if tile.weight_size == (1, 1) or m.masks else -(-slots // SLOTS_PER_LAYER)
    yield "weights", is_list(tile.weights, layers, layers)
    yield "textures", is_list(tile.textures, len(maps), len(maps))
    for kind, texture in zip(maps, tile.textures, strict=True):
        yield from _texture_checks(texture, kind, slots)
    first = tile.textures[0].size
    yield "weight_size", all(low <= high for low, high in zip(tile.weight_size, first, strict=True))


def _texture_checks(texture: TextureEntry, kind: MapEntry, slots: int) -> Checks:
    yield "size", is_size(texture.size)
    yield "neutral_bits", type(texture.neutral_bits) is int and texture.neutral_bits in (8, 16)
    yield "differences", is_list(texture.differences, slots, slots)
    yield "difference_span", is_table(texture.difference_span, (slots, slots), kind.channels, 0)


def _geometry_checks(geometry: GeometryEntry) -> Checks:
    yield "geometry", is_list(geometry.files, 1, 2)
    yield "vertices", is_count(geometry.vertices, 1, MAX_CORNERS)
    yield "triangles", is_count(geometry.triangles, 1, MAX_CORNERS)


def _file_checks(m: Manifest) -> Checks:
    """Every file stands in the manifest once, and nothing else does."""
    named = [name for _, texture in m.entries().values() for name in (texture.neutral, *texture.differences)]
    named += [name for tile in m.tiles for name in tile.weights]
    named += m.geometry.files if m.geometry else ()
    named += (*m.masks.files, m.masks.activations) if m.masks else ()
    yield "files", all(isinstance(name, str) for name in named) and len({*named}) == len(named)
    yield "files", {*m.files} == {*named} and MANIFEST not in named
    for file in m.files.values():
        yield "files", isinstance(file.sha256, str) and SHA256.fullmatch(file.sha256) is not None
        yield "files", is_count(file.bytes, 1, 2**40)
    if m.masks is not None:
        numbers = len(m.expressions) * len(m.masks.names) * len(m.tiles[0].weight_span)
        yield "activations", m.files[m.masks.activations].bytes == BYTES_OF_AN_ACTIVATION * numbers


def _proportions(m: Manifest) -> Checks:
    for kind, texture in m.entries().values():
        texels = math.prod((*texture.size, kind.image_channels))
        yield "size", is_in_proportion(texels * texture.neutral_bits // 8, m, texture.neutral)
        for file in texture.differences:
            yield "size", is_in_proportion(texels, m, file)
    for tile in m.tiles:
        for file in tile.weights:
            yield "weight_size", is_in_proportion(math.prod(atlas_shape(tile, len(m.expressions))), m, file)
    if m.masks is not None:
        for tile, file in zip(m.tiles, m.masks.files, strict=True):
            yield "weight_size", is_in_proportion(math.prod(atlas_shape(tile, m.masks.fours)), m, file)


def is_in_proportion(decoded: int, m: Manifest, name: str) -> bool:
    """Whether a file unfolds to so many bytes that it may well hold them."""
    return decoded <= max(SPARE, MOST_EXPANSION * m.files[name].bytes)


def are_names(names: tuple[Any, ...]) -> bool:
    """Whether all are safe names, and different ones to every file system."""
    return all(isinstance(name, str) for name in names) and first_unusable(names) is None


def is_size(size: Any) -> bool:
    """Whether these are rows and columns of an image."""
    return is_list(size, 2, 2) and all(is_count(side, 1, MAX_SIDE) for side in size)


def is_table(rows: Any, counts: tuple[int, int], columns: int, low: float) -> bool:
    """Whether there are as many rows as allowed, each of so many numbers."""
    return is_list(rows, *counts) and all(are_numbers(row, columns, low) for row in rows)


def are_numbers(values: Any, count: int, low: float) -> bool:
    """Whether these are so many numbers of at least ``low``."""
    return is_list(values, count, count) and all(is_number(value, low) for value in values)


def is_list(values: Any, fewest: int, most: int) -> bool:
    """Whether this is a list of an allowed length."""
    return isinstance(values, tuple) and fewest <= len(values) <= most


def is_count(value: Any, low: int, high: int) -> bool:
    """Whether this is a whole number within a range, and no truth value."""
    return type(value) is int and low <= value <= high


def is_number(value: Any, low: float) -> bool:
    """Whether this is a number of at least ``low``, and none that is huge."""
    return type(value) in (int, float) and low <= value <= MAX_NUMBER
