"""The range of every field of a manifest of version 2 (docs/pack-format.md)."""

import math
from collections.abc import Iterator

from facezip.character.maps import ENCODINGS, MAX_RANGE, is_map_name
from facezip.character.surface import FIRST_TILE, LAST_TILE
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.ranges import (
    MAX_ATLAS_SIDE,
    MAX_DIFFERENCES,
    MAX_NUMBER,
    are_numbers,
    common_checks,
    is_count,
    is_in_proportion,
    is_list,
    is_size,
    is_table,
    stored_checks,
)
from facezip.pack.surface_manifest import StoredMap, StoredTexture, StoredTile, SurfaceManifest

MAX_MAPS = 16
MAX_TILES = 100

Checks = Iterator[tuple[str, bool]]


def first_out_of_range(manifest: SurfaceManifest) -> str | None:
    """The name of the first field that is outside its range, None where all are inside."""
    return next((name for name, passed in _checks(manifest) if not passed), None)


def atlas_shape(tile: StoredTile, count: int) -> tuple[int, int, int]:
    """Rows, columns and channels of the image that holds four slots of ``count`` weight maps."""
    h, w = tile.weight_size
    return -(-count // tile.weight_columns) * h, tile.weight_columns * w, SLOTS_PER_LAYER


# Lazily: each check may rely on those before it.
def _checks(m: SurfaceManifest) -> Checks:
    yield from common_checks(m)
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
    yield "weight_scale", is_list(m.tiles[0].weight_scale, 1, MAX_DIFFERENCES)
    slots, count = len(m.tiles[0].weight_scale), len(m.expressions)
    for tile in m.tiles:
        yield from _tile_checks(tile, m.maps, slots, count)
    uniform = [tile.weight_size == (1, 1) for tile in m.tiles]
    yield "weight_size", all(uniform) or not any(uniform)
    rows = count if uniform[0] else 0
    yield "uniform_weights", is_table(m.uniform_weights, (rows, rows), slots, -MAX_NUMBER)
    yield from stored_checks(m, _images(m))
    yield from _proportions(m)


def _map_checks(kind: StoredMap) -> Checks:
    yield "maps", is_map_name(kind.name)
    yield "encoding", isinstance(kind.encoding, str) and kind.encoding in ENCODINGS
    yield "range", are_numbers(kind.range, 2, -MAX_RANGE) and kind.range[0] < kind.range[1] <= MAX_RANGE
    yield "range", kind.encoding != "normal" or kind.range == (-1, 1)
    yield "channels", is_count(kind.channels, 1, 4) and (kind.encoding != "normal" or kind.channels == 2)


def _tile_checks(tile: StoredTile, maps: tuple[StoredMap, ...], slots: int, count: int) -> Checks:
    yield "weight_size", is_size(tile.weight_size)
    yield "weight_columns", is_count(tile.weight_columns, 1, count)
    yield "weight_columns", max(atlas_shape(tile, count)) <= MAX_ATLAS_SIDE
    yield "weight_scale", are_numbers(tile.weight_scale, slots, 0)
    yield "weight_offset", are_numbers(tile.weight_offset, slots, -MAX_NUMBER)
    yield "textures", is_list(tile.textures, len(maps), len(maps))
    for kind, texture in zip(maps, tile.textures, strict=True):
        yield from _texture_checks(texture, kind, slots)
    first = tile.textures[0].size
    yield "weight_size", all(low <= high for low, high in zip(tile.weight_size, first, strict=True))


def _texture_checks(texture: StoredTexture, kind: StoredMap, slots: int) -> Checks:
    yield "size", is_size(texture.size)
    yield "neutral_bits", type(texture.neutral_bits) is int and texture.neutral_bits in (8, 16)
    yield "difference_scale", is_table(texture.difference_scale, (slots, slots), kind.channels, 0)


def _images(m: SurfaceManifest) -> list[str]:
    textures = [
        file
        for tile in m.tiles
        for kind in m.maps
        for file in (tile.neutral_file(kind.name), *tile.difference_files(kind.name))
    ]
    return [*textures, *(file for tile in m.tiles for file in tile.weight_files)]


def _proportions(m: SurfaceManifest) -> Checks:
    for tile in m.tiles:
        for kind, texture in zip(m.maps, tile.textures, strict=True):
            texels = math.prod((*texture.size, kind.stored_channels))
            yield "size", is_in_proportion(texels * texture.neutral_bits // 8, m, tile.neutral_file(kind.name))
            for file in tile.difference_files(kind.name):
                yield "size", is_in_proportion(texels, m, file)
        for file in tile.weight_files:
            yield "weight_size", is_in_proportion(math.prod(atlas_shape(tile, len(m.expressions))), m, file)
