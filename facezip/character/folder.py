"""Characters as folders: ``NAME.png``, ``NAME.normal.png``, ``NAME.1002.png``, ``NAME.roughness.1002.exr`` …"""

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.correspondence import in_order_of
from facezip.character.filenames import MASK
from facezip.character.layout import Layout, MapFiles, read_layout
from facezip.character.maps import ALBEDO, Key, Map
from facezip.character.meshes import Meshes
from facezip.character.neutrals import neutral_bits, packed_neutral
from facezip.character.raster import covered
from facezip.character.scans import NEUTRAL, Character, Stack, check_names
from facezip.character.texels import normal_rows, states_signs, value_rows
from facezip.character.tiles import FIRST_TILE, shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import filled
from facezip.files.decoding import stated_size
from facezip.files.images import Texels, to_float, write_texture, write_values
from facezip.files.obj import read_obj, write_obj
from facezip.files.reading import check_expansion
from facezip.files.values import read_mask
from facezip.files.writing import whole_folder
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.machine.progress import task
from facezip.machine.rows import by_rows, map_rows
from facezip.names import printable

# Fifty flat 2048 x 2048 textures are no attack; what unfolds to more has to be in proportion to its files.
SPARE = 2**32
# Of a texel: exporters round UVs, each in its own way.
UV_TOLERANCE = 1 / 16


def load_folder(folder: Path, keep_floats: bool, maps: tuple[str, ...] | None) -> Character:
    """Read a folder; parameters and errors as of :func:`facezip.load_character`."""
    layout = read_layout(folder)
    if maps is not None:
        layout = replace(layout, maps=tuple(how for how in layout.maps if how.kind.name in maps))
    if keep_floats:
        layout = replace(layout, maps=tuple(replace(how, keeps_floats=True) for how in layout.maps))
    check_names(layout.expressions, folder)
    _check_sizes(layout)
    count = (1 + len(layout.expressions)) * (1 + len(layout.maps) * len(layout.tiles))
    with ThreadPoolExecutor(cores()) as pool, task("Reading the character", count) as done:
        return _Loading(layout, pool, done).character()


def save_folder(character: Character, folder: Path) -> None:
    """Write a folder; errors as of :func:`facezip.save_character`."""
    names, tiles = (NEUTRAL, *character.expressions), character.tiles
    with whole_folder(folder, False, lambda _: False) as made, task("Writing the character", len(names)) as done:
        for name in names:
            write_obj(made / f"{name}.obj", character.mesh_vertices(name), character.meshes.topology)
            for kind in character.maps:
                for tile in tiles:
                    stem = made / file_name(name, kind, tile, tiles)
                    write_map(stem, character.texels(name, (kind.name, tile)), kind)
            done()
        for tile, stack in character.of_map(character.maps[0].name).items():
            if stack.mask is not None:
                write_texture(made / f"{MASK}{_tile(tile, tiles)}.png", stack.mask[:, :, None])


def file_name(name: str, kind: Map, tile: int, tiles: tuple[int, ...]) -> str:
    """What a texture is called, without its suffix."""
    return f"{name}{'' if kind.name == ALBEDO else '.' + kind.name}{_tile(tile, tiles)}"


def write_map(stem: Path, texels: Texels, kind: Map, bits: int | None = None) -> Path:
    """Write texels ``(H, W, C)`` as PNG, or as OpenEXR where they are floats of colour or data; the path.

    Parameters
    ----------
    stem : the path without its suffix.
    texels, kind : what to write.
    bits : 8 or 16 of a PNG, whatever the texels are; None for what they hold.
    """
    if not kind.is_normal and (not kind.is_plain or (bits is None and texels.dtype.kind == "f")):
        path, values = stem.with_name(f"{stem.name}.exr"), kind.decode(texels)
        if kind.encoding == "srgb":
            write_texture(path, values)
        else:
            write_values(path, values[:, :, 0])
        return path
    path = stem.with_name(f"{stem.name}.png")
    as_they_are = bits is None and not kind.is_normal
    bits = bits or neutral_bits(texels.dtype, kind.is_normal)
    write_texture(path, texels if as_they_are else packed_neutral(texels, kind, bits))
    return path


def _tile(tile: int, tiles: tuple[int, ...]) -> str:
    return "" if tiles == (FIRST_TILE,) else f".{tile}"


class _Loading:
    """One call of :func:`load_folder`."""

    def __init__(self, layout: Layout, pool: Executor, done: Callable[[], None]) -> None:
        self._layout, self._names, self._pool, self._done = layout, layout.expressions, pool, done
        sides = (stated_size(how.files[NEUTRAL, tile])[:2] for how in layout.maps for tile in layout.tiles)
        self._tolerance = UV_TOLERANCE / max(map(max, sides))

    def character(self) -> Character:
        # Their parsers leave the interpreter to other threads: meshes and textures are read side by side.
        self._neutral, self._topology = read_obj(self._layout.meshes[NEUTRAL])
        self._done()
        moved = [self._pool.submit(self._vertices, name) for name in self._names]
        maps: list[Map] = []
        stacks: dict[Key, Stack] = {}
        for how in self._layout.maps:
            kind, tiles = self._map(how)
            maps.append(kind)
            stacks |= {(kind.name, tile): stack for tile, stack in tiles.items()}
        vertices = np.stack([future.result() for future in moved])
        name = printable(self._layout.folder.resolve().name)
        return Character(name, self._names, Meshes(self._topology, self._neutral, vertices), tuple(maps), stacks)

    def _vertices(self, name: str) -> NDArray[np.float32]:
        path = self._layout.meshes[name]
        vertices = in_order_of(path, self._neutral, self._topology, *read_obj(path), self._tolerance)
        self._done()
        return vertices

    def _map(self, how: MapFiles) -> tuple[Map, dict[int, Stack]]:
        """A map on all tiles; floats that are kept share one range."""
        signed = how.kind.is_normal and states_signs(how.files[NEUTRAL, self._layout.tiles[0]])
        stacks = {tile: self._stack(how, tile, signed) for tile in self._layout.tiles}
        kind = how.kind
        if how.keeps_floats and not kind.is_normal:
            extents = [_extent(stack) for stack in stacks.values() if stack.neutral.dtype.kind == "f"]
            low, high = min([0.0, *(least for least, _ in extents)]), max([1.0, *(most for _, most in extents)])
            kind = replace(kind, low=low, high=high)
            if not kind.is_plain:
                stacks = {tile: _encoded(stack, kind) for tile, stack in stacks.items()}
        return kind, stacks

    def _stack(self, how: MapFiles, tile: int, signed: bool) -> Stack:
        seen = self._seen(tile, stated_size(how.files[NEUTRAL, tile])[:2]) if how.kind.is_normal else None

        def read(name: str, into: Texels | None = None) -> Texels:
            path = how.files[name, tile]
            texture = filled(value_rows(path, how) if seen is None else normal_rows(path, how, signed, seen), into)
            self._done()
            return texture

        neutral = read(NEUTRAL)
        textures: Texels = memory.empty((len(self._names), *neutral.shape), neutral.dtype)

        def fill(name: str, into: Texels) -> None:
            texture = read(name, into)
            if texture is not into:
                raise FaceZipError(
                    ErrorCode.SIZE_MISMATCH,
                    f"{how.files[name, tile]}: {words_for(texture)}, the neutral is {words_for(neutral)}; export both "
                    "alike",
                )

        list(self._pool.map(fill, self._names, textures))
        return Stack(neutral, textures, self._mask(how, tile, neutral.shape[:2]))

    def _mask(self, how: MapFiles, tile: int, size: tuple[int, ...]) -> NDArray[np.float32] | None:
        path = self._layout.masks.get(tile)
        if path is None:
            return None
        mask = read_mask(path)
        if how.kind.name != ALBEDO and mask.shape != size:
            # The mask has the albedo's size; other maps may be finer or coarser.
            mask = _resized(mask, size)
        if len(self._layout.tiles) > 1 and not mask.any():
            # One of several tiles, such as that of the back of the head, need not show any of the face.
            blank: NDArray[np.float32] = memory.zeros(size, np.float32)
            return blank
        return checked_mask(mask, size, path)

    def _seen(self, tile: int, size: tuple[int, int]) -> NDArray[np.bool_]:
        """Texels on the mesh, within the mask."""
        on_mesh = covered(shifted(self._topology, tile), size)
        path = self._layout.masks.get(tile)
        if path is None:
            return on_mesh
        mask = _resized(read_mask(path), size)
        return by_rows(lambda rows: on_mesh[rows] & (mask[rows] > 0), size, np.bool_)


def words_for(texture: Texels) -> str:
    """Size, channels and type of a texture."""
    height, width, channels = texture.shape
    return f"{width}x{height} with {channels} channel(s) of {texture.dtype}"


def checked_mask(mask: NDArray[np.float32], size: tuple[int, ...], path: Path) -> NDArray[np.float32]:
    """The face region ``(H, W)`` of an image at ``path``, if it has the textures' size and is not black everywhere."""
    if mask.shape != size:
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{path}: {mask.shape[1]}x{mask.shape[0]}, the textures differ; resize the mask",
        )
    if mask.max() == 0:
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: the mask is black everywhere; paint the face region white")
    return mask


def _check_sizes(layout: Layout) -> None:
    """Refuse, by headers alone, textures of a tile that differ, or that unfold out of proportion."""
    decoded = stored = row = 0
    for how in layout.maps:
        for tile in layout.tiles:
            paths = [how.files[name, tile] for name in (NEUTRAL, *layout.expressions)]
            sizes = [stated_size(path) for path in paths]
            for path, size in zip(paths, sizes, strict=True):
                if size[:2] != sizes[0][:2]:
                    raise FaceZipError(
                        ErrorCode.SIZE_MISMATCH,
                        f"{path}: {size[1]}x{size[0]}, the neutral is {sizes[0][1]}x{sizes[0][0]}; export both alike",
                    )
            unfolded = sum(size[2] for size in sizes)
            decoded, row = decoded + unfolded, max(row, unfolded // sizes[0][0])
            stored += sum(path.stat().st_size for path in paths)
    check_expansion(layout.folder, decoded, stored, SPARE)
    memory.check(row)


def _resized(mask: NDArray[np.float32], size: tuple[int, ...]) -> NDArray[np.float32]:
    """The nearest texels of a mask."""
    down, across = (np.arange(to) * of // to for to, of in zip(size, mask.shape, strict=True))
    return by_rows(lambda rows: mask[down[rows]][:, across], size, np.float32)


def _extent(stack: Stack) -> tuple[float, float]:
    """The least and the largest value."""

    def block(top: int, bottom: int) -> tuple[float, float]:
        parts = stack.neutral[top:bottom], stack.textures[:, top:bottom]
        return min(float(part.min()) for part in parts), max(float(part.max()) for part in parts)

    blocks = map_rows(block, len(stack.neutral))
    return min(low for low, _ in blocks), max(high for _, high in blocks)


def _encoded(stack: Stack, kind: Map) -> Stack:
    """A stack of values as texels of a map's range."""

    def rows(some: slice) -> NDArray[np.float32]:
        return kind.encode(to_float(stack.textures[:, some]))

    textures = by_rows(rows, stack.textures.shape, np.float32, axis=1)
    return replace(stack, neutral=kind.encode(to_float(stack.neutral)), textures=textures)
