"""Surfaces as folders: ``NAME.png``, ``NAME.normal.png``, ``NAME.1002.png``, ``NAME.roughness.1002.exr`` …"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.layout import Layout, MapFiles, is_layered, read_layout
from facezip.character.maps import ALBEDO, MapKind
from facezip.character.neutrals import neutral_bits, packed_neutral
from facezip.character.raster import covered
from facezip.character.scans import (
    MASK,
    NEUTRAL,
    SPARE,
    Character,
    check_names,
    kind_of,
    load_character,
    mask_of,
    save_character,
    vertices_like,
)
from facezip.character.surface import FIRST_TILE, Surface, shifted
from facezip.character.texels import normal_rows, states_signs, value_rows
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import filled
from facezip.files.decoding import stated_size
from facezip.files.images import Texels, read_texture, to_float, write_texture
from facezip.files.images import write_values as write_floats
from facezip.files.names import printable
from facezip.files.obj import read_obj, write_obj
from facezip.files.reading import check_expansion, reading
from facezip.files.writing import whole_folder
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.machine.progress import task
from facezip.machine.rows import by_rows, map_rows


def load_surface(path: str | Path, *, keep_floats: bool = False, maps: tuple[str, ...] | None = None) -> Surface:
    """Read a character with all its maps and tiles.

    Beside ``NAME.obj`` lie ``NAME.png`` and, each optional, ``NAME.normal.png``, ``NAME.roughness.png``,
    ``NAME.specular.png`` and ``NAME.cavity.png``; with UDIM, ``NAME.1001.png``, ``NAME.normal.1001.png`` … and
    ``mask.1001.png``. Other names are said in ``character.toml`` (docs/maps.md). PNG, TIFF, JPEG or OpenEXR.

    Parameters
    ----------
    path : the folder; a ``.glb`` has one albedo.
    keep_floats : whether floats outside [0, 1] are kept, with their range, instead of refused.
    maps : names of the maps that are wanted, albedo among them; None for all.

    Raises
    ------
    FaceZipError
        One line that names the file; as :func:`facezip.load_character`, and what :mod:`facezip.character.layout` and
        :mod:`facezip.character.texels` refuse.
    """
    path = Path(path)
    with reading(path):
        if path.suffix.lower() == ".glb" or not (keep_floats or is_layered(path)):
            return Surface.of(load_character(path))
        layout = read_layout(path)
        if maps is not None:
            layout = replace(layout, maps=tuple(one for one in layout.maps if one.kind.name in maps))
        if keep_floats:
            layout = replace(layout, maps=tuple(replace(one, keeps_floats=True) for one in layout.maps))
        return _Loading(layout).surface()


def save_surface(surface: Surface, folder: str | Path) -> None:
    """Write a folder that :func:`load_surface` reads back; normals of 8 bits as PNG of 8, others of 16.

    Raises
    ------
    FaceZipError
        ``UNSAFE_NAME``, or ``CANNOT_WRITE``; nothing is then written.
    """
    if surface.ordinary:
        save_character(surface.whole, folder)
        return
    whole = surface.whole
    check_names(whole.expressions, whole.name)
    names = (NEUTRAL, *whole.expressions)
    with whole_folder(Path(folder), False, lambda _: False) as made, task("Writing the character", len(names)) as done:
        for name in names:
            write_obj(made / f"{name}.obj", whole.mesh_vertices(name), surface.topology)
            for kind in surface.maps:
                for tile in surface.tiles:
                    part = surface.parts[kind.name, tile]
                    stored = part.neutral if name == NEUTRAL else part.textures[part.index(name)]
                    write_map(made / file_name(name, kind, tile, surface.tiles), stored, kind)
            done()
        for tile, part in zip(surface.tiles, surface.of_map(ALBEDO), strict=True):
            if part.mask is not None:
                write_texture(made / f"{MASK}{_tile(tile, surface.tiles)}.png", part.mask[:, :, None])


def file_name(name: str, kind: MapKind, tile: int, tiles: tuple[int, ...]) -> str:
    """What a texture is called, without its suffix."""
    return f"{name}{'' if kind.name == ALBEDO else '.' + kind.name}{_tile(tile, tiles)}"


def write_map(stem: Path, fitted: Texels, kind: MapKind, bits: int | None = None) -> Path:
    """Write fitted texels ``(H, W, C)`` as PNG, or as OpenEXR where they are floats of colour or data; the path.

    Parameters
    ----------
    stem : the path without its suffix.
    fitted, kind : what to write.
    bits : 8 or 16 of a PNG, whatever the texels are; None for what they hold.
    """
    if not kind.is_normal and (not kind.ordinary or (bits is None and fitted.dtype.kind == "f")):
        path, values = stem.with_name(f"{stem.name}.exr"), kind.values(fitted)
        if kind.encoding == "srgb":
            write_texture(path, values)
        else:
            write_floats(path, values[:, :, 0])
        return path
    path = stem.with_name(f"{stem.name}.png")
    kept = bits is None and not kind.is_normal
    bits = bits or neutral_bits(fitted.dtype, kind.is_normal)
    write_texture(path, fitted if kept else packed_neutral(fitted, kind, bits))
    return path


def _tile(tile: int, tiles: tuple[int, ...]) -> str:
    return "" if tiles == (FIRST_TILE,) else f".{tile}"


# A neutral (H, W, C) and its expressions (N, H, W, C).
Stack = tuple[Texels, Texels]


class _Loading:
    """One call of :func:`load_surface`."""

    def __init__(self, layout: Layout) -> None:
        self._layout, self._names = layout, layout.expressions
        check_names(self._names, layout.folder)
        self._check_sizes()
        self._neutral, self._topology = read_obj(layout.meshes[NEUTRAL])
        self._vertices: NDArray[np.float32] = np.stack(
            [vertices_like(layout.meshes[name], self._neutral, self._topology) for name in self._names]
        )

    def surface(self) -> Surface:
        count = len(self._layout.maps) * len(self._layout.tiles) * (1 + len(self._names))
        with ThreadPoolExecutor(cores()) as pool, task("Reading the character", count) as done:
            self._pool, self._done = pool, done
            maps: list[MapKind] = []
            parts: dict[tuple[str, int], Character] = {}
            for how in self._layout.maps:
                kind, tiles = self._map(how)
                maps.append(kind)
                parts |= {(kind.name, tile): part for tile, part in tiles.items()}
        return Surface(self._topology, tuple(maps), parts)

    def _map(self, how: MapFiles) -> tuple[MapKind, dict[int, Character]]:
        """A map on all tiles; floats that are kept share one range."""
        signed = how.kind.is_normal and states_signs(how.files[NEUTRAL, self._layout.tiles[0]])
        stacks = {tile: self._stack(how, tile, signed) for tile in self._layout.tiles}
        kind = how.kind
        if how.keeps_floats and not kind.is_normal:
            extents = [_extent(stack) for stack in stacks.values() if stack[0].dtype.kind == "f"]
            low, high = min([0.0, *(least for least, _ in extents)]), max([1.0, *(most for _, most in extents)])
            kind = replace(kind, low=low, high=high)
            if not kind.ordinary:
                stacks = {tile: _fitted(stack, kind) for tile, stack in stacks.items()}
        return kind, {tile: self._part(how, tile, stack) for tile, stack in stacks.items()}

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
                    f"{how.files[name, tile]}: {kind_of(texture)}, the neutral is {kind_of(neutral)}; export both "
                    "alike",
                )

        list(self._pool.map(fill, self._names, textures))
        return neutral, textures

    def _part(self, how: MapFiles, tile: int, stack: Stack) -> Character:
        neutral, textures = stack
        return Character(
            printable(self._layout.folder.resolve().name),
            shifted(self._topology, tile),
            self._names,
            self._neutral,
            self._vertices,
            neutral,
            textures,
            self._mask(how, tile, neutral),
        )

    def _mask(self, how: MapFiles, tile: int, neutral: Texels) -> NDArray[np.float32] | None:
        path = self._layout.masks.get(tile)
        if path is None:
            return None
        texels = read_texture(path)
        if how.kind.name != ALBEDO and texels.shape[:2] != neutral.shape[:2]:
            # The mask has the albedo's size; other maps may be finer or coarser.
            texels = _resized(texels, neutral.shape[:2])
        if len(self._layout.tiles) > 1 and not texels.any():
            # One of several tiles, such as that of the back of the head, need not show any of the face.
            blank: NDArray[np.float32] = memory.zeros(neutral.shape[:2], np.float32)
            return blank
        return mask_of(texels, neutral, path)

    def _seen(self, tile: int, size: tuple[int, int]) -> NDArray[np.bool_]:
        """Texels on the mesh, within the mask."""
        on_mesh = covered(shifted(self._topology, tile), size)
        path = self._layout.masks.get(tile)
        if path is None:
            return on_mesh
        mask = _resized(read_texture(path), size)
        return by_rows(lambda rows: on_mesh[rows] & (mask[rows, :, 0] > 0), size, np.bool_)

    def _check_sizes(self) -> None:
        """Refuse, by headers alone, textures of a tile that differ, or that unfold out of proportion."""
        decoded = stored = row = 0
        for how in self._layout.maps:
            for tile in self._layout.tiles:
                paths = [how.files[name, tile] for name in (NEUTRAL, *self._names)]
                sizes = [stated_size(path) for path in paths]
                for path, size in zip(paths, sizes, strict=True):
                    if size[:2] != sizes[0][:2]:
                        raise FaceZipError(
                            ErrorCode.SIZE_MISMATCH,
                            f"{path}: {size[1]}x{size[0]}, the neutral is {sizes[0][1]}x{sizes[0][0]}; export both "
                            "alike",
                        )
                unfolded = sum(size[2] for size in sizes)
                decoded, row = decoded + unfolded, max(row, unfolded // sizes[0][0])
                stored += sum(path.stat().st_size for path in paths)
        check_expansion(self._layout.folder, decoded, stored, SPARE)
        memory.check(row)


def _resized(mask: Texels, size: tuple[int, int]) -> Texels:
    """The nearest texels of a mask."""
    down, across = (np.arange(to) * of // to for to, of in zip(size, mask.shape, strict=False))
    return by_rows(lambda rows: mask[down[rows]][:, across], (*size, mask.shape[2]), mask.dtype)


def _extent(stack: Stack) -> tuple[float, float]:
    """The least and the largest value."""
    neutral, textures = stack

    def block(top: int, bottom: int) -> tuple[float, float]:
        parts = neutral[top:bottom], textures[:, top:bottom]
        return min(float(part.min()) for part in parts), max(float(part.max()) for part in parts)

    blocks = map_rows(block, len(neutral))
    return min(low for low, _ in blocks), max(high for _, high in blocks)


def _fitted(stack: Stack, kind: MapKind) -> Stack:
    neutral, textures = stack

    def rows(some: slice) -> NDArray[np.float32]:
        return kind.fitted(to_float(textures[:, some]))

    return kind.fitted(to_float(neutral)), by_rows(rows, textures.shape, np.float32, axis=1)
