"""The range of every field of a manifest, as docs/pack-format.md has it: its ends are inside, what is beyond is not."""

from dataclasses import replace

import pytest

from facezip.pack.checks import atlas_shape, first_out_of_range
from facezip.pack.manifest import GeometryEntry, Manifest, MapEntry, MasksEntry, StoredFile, TextureEntry, TileEntry

NAMES = ("smile", "frown", "pout")
# Than any number of a manifest may be.
MORE = 1e9 + 1


def files_of(m):
    """Every file that a manifest names, so large that it may hold anything; activations are as long as they are."""
    named = [name for tile in m.tiles for texture in tile.textures for name in (texture.neutral, *texture.differences)]
    named += [name for tile in m.tiles for name in tile.weights]
    named += m.geometry.files if m.geometry else ()
    files = {name: StoredFile(2**32, "0" * 64) for name in (*named, *(m.masks.files if m.masks else ()))}
    if m.masks:
        numbers = len(m.expressions) * len(m.masks.names) * len(m.tiles[0].weight_span)
        files[m.masks.activations] = StoredFile(2 * numbers, "0" * 64)
    return files


def listed(m):
    return replace(m, files=files_of(m))


def texture_of(name, tile, channels, slots=2):
    differences = tuple(f"{name}.{tile}.difference_{i}.png" for i in range(slots))
    return TextureEntry((64, 64), f"{name}.{tile}.neutral.png", differences, 8, ((1.0,) * channels,) * slots)


def tile_of(number, slots=2):
    weights = tuple(f"weights_{layer}.{number}.png" for layer in range(-(-slots // 4)))
    textures = texture_of("albedo", number, 3, slots), texture_of("normal", number, 2, slots)
    return TileEntry(number, (4, 8), 2, (1.0,) * slots, (0.0,) * slots, weights, textures)


def stored(slots=2, numbers=(1001, 1002)):
    """Weight maps as images."""
    maps = MapEntry("albedo", "srgb", (0, 1), 3), MapEntry("normal", "normal", (-1, 1), 2)
    tiles = tuple(tile_of(number, slots) for number in numbers)
    return listed(Manifest("me", "refined", NAMES, maps, tiles, (), GeometryEntry(("head.glb",), 9, 9)))


def uniform():
    m = stored()
    tiles = tuple(replace(tile, weight_size=(1, 1), weights=()) for tile in m.tiles)
    return listed(replace(m, tiles=tiles, uniform_weights=((0.5, 0.5),) * 3))


def masked(count=6, numbers=(1001, 1002)):
    m = stored(numbers=numbers)
    names = tuple(f"m{k}" for k in range(count))
    masks = MasksEntry(names, tuple(f"masks.{number}.png" for number in numbers), "activations.f16", False)
    columns = max(1, min(2, masks.fours))
    tiles = tuple(replace(tile, weights=(), weight_columns=columns) for tile in m.tiles)
    return listed(replace(m, masks=masks, tiles=tiles))


def plain(**changes):
    return listed(replace(stored(), **changes))


def in_map(k=0, **changes):
    maps = [*stored().maps]
    maps[k] = replace(maps[k], **changes)
    return replace(stored(), maps=tuple(maps))


def in_tile(m=None, t=0, **changes):
    m = m or stored()
    tiles = [*m.tiles]
    tiles[t] = replace(tiles[t], **changes)
    return replace(m, tiles=tuple(tiles))


def in_texture(m=None, k=0, **changes):
    m = m or stored()
    textures = [*m.tiles[0].textures]
    textures[k] = replace(textures[k], **changes)
    return in_tile(m, textures=tuple(textures))


def in_files(m, name, **changes):
    return replace(m, files=m.files | {name: replace(m.files[name], **changes)})


def of_maps(count):
    """So many maps of data beside each other."""
    maps = tuple(MapEntry(f"map_{k}", "data", (0, 1), 3) for k in range(count))
    tiles = tuple(
        replace(tile, textures=tuple(texture_of(kind.name, tile.number, 3) for kind in maps)) for tile in stored().tiles
    )
    return plain(maps=maps, tiles=tiles)


def of_expressions(count):
    columns = max(1, min(count, 64))
    return plain(
        expressions=tuple(f"e{n}" for n in range(count)),
        tiles=tuple(replace(tile, weight_columns=columns) for tile in stored().tiles),
    )


def with_geometry(**changes):
    return replace(stored(), geometry=replace(stored().geometry, **changes))


def with_masks(m=None, **changes):
    m = m or masked()
    return listed(replace(m, masks=replace(m.masks, **changes)))


@pytest.mark.parametrize("m", [stored(), uniform(), masked(), masked(numbers=(1001,)), plain(geometry=None)])
def test_what_the_format_allows_is_in_range(m):
    assert first_out_of_range(m) is None


# By field: what makes a manifest of a value, the values that are inside, and those that are not.
RANGES = [
    ("name", lambda v: plain(name=v), ["", "é" * 128], ["n" * 129, "two\nlines", 3]),
    ("method", lambda v: plain(method=v), ["m", "m" * 128], ["", "m" * 129, "two\nlines", 3]),
    ("expressions", of_expressions, [1, 4096], [0, 4097]),
    ("expressions", lambda v: plain(expressions=v), [("é", "b", "c")], [("a", "A", "b"), ("a", "b", 3), ["a", "b"]]),
    ("made_with", lambda v: plain(made_with=v), [{}, {"a": 1}], [None, ()]),
    ("maps", of_maps, [1, 16], [0, 17]),
    ("maps", lambda v: in_map(name=v), ["a" * 32, "a_1"], ["a" * 33, "", "A", "1a", "mask", "weights", "normal"]),
    ("encoding", lambda v: in_map(encoding=v), ["srgb", "data"], ["linear", 1]),
    ("range", lambda v: in_map(range=v), [(-1e6, 1e6)], [(-1.1e6, 0), (0, 1.1e6), (1, 1), (1, 0), (0,), (0, 1, 2)]),
    ("range", lambda v: in_map(1, range=v), [(-1, 1)], [(0, 1), (-1, 0.5)]),
    ("channels", lambda v: in_map(channels=v), [], [0, 5, 2.0, True]),
    ("channels", lambda v: in_map(1, channels=v), [2], [1, 3]),
    ("tiles", lambda v: stored(numbers=range(1001, 1001 + v)), [1, 100], [0, 101]),
    ("number", lambda v: stored(numbers=v), [(1001, 1999)], [(1000,), (2000,), (1002, 1001), (1001, 1001), (1001.0,)]),
    ("weight_span", stored, [1, 8], [0, 9]),
    ("weight_span", lambda v: in_tile(t=1, weight_span=v), [(0, 1e9)], [(1, -1), (1, MORE), (1,), (1, 1, 1), (1, "")]),
    ("weight_offset", lambda v: in_tile(weight_offset=v), [(-1e9, 1e9)], [(0, -MORE), (MORE, 0), (0,), (0, "0")]),
    ("weight_size", lambda v: in_tile(weight_size=v), [(1, 2), (64, 64)], [(0, 4), (65, 4), (4, 65), (4,), (4.0, 4)]),
    ("weight_columns", lambda v: in_tile(weight_columns=v), [1, 3], [0, 4, 1.0]),
    ("weights", lambda v: in_tile(stored(4), weights=v), [], [(), ("a", "b")]),
    ("textures", lambda v: in_tile(textures=v), [], [(), stored().tiles[0].textures[:1]]),
    ("size", lambda v: in_texture(k=1, size=v), [(1, 1), (16384, 2)], [(0, 1), (16385, 1), (1, 16385), (4,), (4,) * 3]),
    ("neutral_bits", lambda v: in_texture(neutral_bits=v), [8, 16], [0, 9, 12, 32, 8.0]),
    ("differences", lambda v: in_texture(differences=v), [], [(), ("a",), ("a", "b", "c"), ["a", "b"]]),
    (
        "difference_span",
        lambda v: in_texture(k=1, difference_span=v),
        [((0, 1e9),) * 2],
        [((0, 1),), ((0, 1),) * 3, ((0,),) * 2, ((0, 1, 2),) * 2, ((0, -1),) * 2, ((0, MORE),) * 2],
    ),
    (
        "uniform_weights",
        lambda v: replace(uniform(), uniform_weights=v),
        [((-1e9, 1e9),) * 3],
        [(), ((0, 0),) * 2, ((0, 0),) * 4, ((0,),) * 3, ((0, MORE),) * 3, ((0, -MORE),) * 3],
    ),
    ("uniform_weights", lambda v: replace(stored(), uniform_weights=v), [()], [((0, 0),), ((0, 0),) * 3]),
    ("weight_size", lambda v: in_tile(uniform(), weight_size=v, weights=("weights.png",)), [], [(1, 2), (2, 1)]),
    ("geometry", lambda v: with_geometry(files=v), [], [(), ("a", "b", "c"), "a"]),
    ("vertices", lambda v: with_geometry(vertices=v), [1, 2**24], [0, 2**24 + 1, 1.0]),
    ("triangles", lambda v: with_geometry(triangles=v), [1, 2**24], [0, 2**24 + 1, 1.0]),
    ("masks", lambda v: masked(v), [1, 4096], [0, 4097]),
    ("masks", lambda v: with_masks(names=v), [], [("a", "A"), (3,), ["a", "b"]]),
    ("masks", lambda v: with_masks(files=v), [], [("a",), ("a", "b", "c")]),
    ("masks", lambda v: with_masks(clamped=v), [True, False], [1, None]),
    ("weight_span", lambda v: in_tile(masked(), 1, weight_span=v), [(1, 1)], [(1, 2), (1,), (0, 1)]),
    ("weight_offset", lambda v: in_tile(masked(), weight_offset=v), [(0, 0)], [(0, 1), (0,), (0, 0, 0)]),
    ("weight_columns", lambda v: in_tile(masked(), weight_columns=v), [1, 2], [0, 3]),
    ("weights", lambda v: in_tile(masked(), weights=v), [()], [("weights.png",)]),
    ("activations", lambda v: in_files(masked(), "activations.f16", bytes=v), [72], [36, 71, 73, 144]),
    ("files", lambda v: in_files(stored(), "head.glb", bytes=v), [1, 2**40], [0, 2**40 + 1, 1.0]),
    ("files", lambda v: in_files(stored(), "head.glb", sha256=v), ["0a" * 32], ["0" * 63, "0" * 65, "A" * 64, 0]),
    ("files", lambda v: replace(stored(), files=stored().files | v), [{}], [{"more": StoredFile(1, "0" * 64)}]),
    ("files", lambda v: listed(in_texture(neutral=v)), [], ["manifest.json", "head.glb", "weights_0.1001.png", 3]),
]  # fmt: skip


@pytest.mark.parametrize(("field", "make", "inside"), [(f, m, v) for f, m, values, _ in RANGES for v in values])
def test_what_is_within_a_range_is_allowed(field, make, inside):
    assert first_out_of_range(make(inside)) is None


@pytest.mark.parametrize(("field", "make", "outside"), [(f, m, v) for f, m, _, values in RANGES for v in values])
def test_what_is_beyond_a_range_is_named(field, make, outside):
    assert first_out_of_range(make(outside)) == field


def test_uniform_weights_and_masks_exclude_each_other():
    m = masked()
    tiles = tuple(replace(tile, weight_size=(1, 1)) for tile in m.tiles)
    assert first_out_of_range(replace(m, tiles=tiles)) == "weight_size"


@pytest.mark.parametrize(("columns", "rows"), [(1, 3), (2, 2), (3, 1)])
def test_an_atlas_holds_all_maps_in_rows_of_so_many(columns, rows):
    tile = replace(stored().tiles[0], weight_columns=columns)
    assert atlas_shape(tile, 3) == (rows * 4, columns * 8, 4)


@pytest.mark.parametrize("side", ["rows", "columns"])
@pytest.mark.parametrize(("count", "size", "found"), [(4, 16384, None), (5, 13108, "weight_columns")])
def test_no_side_of_an_atlas_is_above_65536(side, count, size, found):
    """Weight maps side by side, or one below the other."""
    names, columns = tuple(f"e{n}" for n in range(count)), count if side == "columns" else 1
    weight_size = (1, size) if side == "columns" else (size, 1)
    tiles = tuple(
        replace(
            tile,
            weight_columns=columns,
            weight_size=weight_size,
            textures=tuple(replace(texture, size=(16384, 16384)) for texture in tile.textures),
        )
        for tile in stored().tiles
    )
    assert first_out_of_range(plain(expressions=names, tiles=tiles)) == found


LARGE = 2**28
OF_FILES = [
    # Texels of a neutral with as many bytes as it has bits for, of a difference with one; three channels of normals.
    ("albedo.1001.neutral.png", "size", lambda: in_texture(size=(16384, 16384)), 3 * LARGE),
    ("albedo.1001.neutral.png", "size", lambda: in_texture(size=(16384, 8192), neutral_bits=16), 3 * LARGE),
    ("albedo.1001.difference_1.png", "size", lambda: in_texture(size=(16384, 16384)), 3 * LARGE),
    ("normal.1001.difference_0.png", "size", lambda: in_texture(k=1, size=(16384, 16384)), 3 * LARGE),
    # Two rows of two atlas places, four slots in each, and of masks one row of four in each.
    ("weights_0.1001.png", "weight_size", lambda: large_weights(stored()), 4 * 2 * 2 * 8192 * 8192),
    ("masks.1001.png", "weight_size", lambda: large_weights(masked()), 4 * 2 * 8192 * 8192),
]


def large_weights(m):
    return in_tile(in_texture(m, size=(16384, 16384)), weight_size=(8192, 8192))


@pytest.mark.parametrize(("file", "field", "make", "expanded"), OF_FILES)
def test_a_file_expands_to_200_times_its_bytes_and_no_more(file, field, make, expanded):
    fewest = -(-expanded // 200)
    assert first_out_of_range(in_files(make(), file, bytes=fewest)) is None
    assert first_out_of_range(in_files(make(), file, bytes=fewest - 1)) == field


@pytest.mark.parametrize(("columns", "found"), [(8192, None), (8193, "size")])
def test_what_expands_to_256_mib_needs_no_large_file(columns, found):
    """A channel of 16 bits."""
    m = in_texture(in_map(channels=1), size=(16384, columns), neutral_bits=16, difference_span=((1,),) * 2)
    m = in_tile(m, 1, textures=(replace(m.tiles[1].textures[0], difference_span=((1,),) * 2), m.tiles[1].textures[1]))
    assert first_out_of_range(in_files(m, "albedo.1001.neutral.png", bytes=1)) == found
