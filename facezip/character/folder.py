"""Characters as folders: ``NAME.png``, ``NAME.normal.png``, ``NAME.1002.png``, ``NAME.roughness.1002.exr`` …"""

from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character import appearance
from facezip.character.filenames import MASK
from facezip.character.folder_meshes import FolderMeshes
from facezip.character.layout import Layout, MapFiles, read_layout
from facezip.character.maps import ALBEDO, Key, Map
from facezip.character.masks import read_face, seen, sized_for
from facezip.character.meshes import Meshes
from facezip.character.neutrals import neutral_bits, packed_neutral
from facezip.character.notes import Note
from facezip.character.obj_parts import Mesh
from facezip.character.placement import Placement, placed
from facezip.character.scans import NEUTRAL, Character, Stack, check_names
from facezip.character.settings import SETTINGS, Settings
from facezip.character.sizes import Sizes, read_sizes, words_for
from facezip.character.texels import Extremes, normal_rows, states_signs, value_rows
from facezip.character.tiles import FIRST_TILE, shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import filled
from facezip.files.images import Texels, as_texels, to_float, write_texture, write_values
from facezip.files.obj import write_obj
from facezip.files.statements import stated
from facezip.files.writing import whole_folder
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.machine.progress import task
from facezip.machine.rows import by_rows, map_rows
from facezip.names import printable


def load_folder(
    folder: Path, settings: Settings, keep_floats: bool, maps: tuple[str, ...] | None, fewest: int
) -> Character:
    """Read a folder as its ``character.toml`` says; the rest as of :func:`facezip.load_character`."""
    layout = read_layout(folder, settings, fewest=fewest)
    if maps is not None:
        layout = replace(layout, maps=tuple(how for how in layout.maps if how.kind.name in maps))
    if keep_floats:
        layout = replace(layout, maps=tuple(replace(how, keeps_floats=True) for how in layout.maps))
    check_names(layout.expressions, folder)
    sizes = read_sizes(layout)
    count = (1 + len(layout.expressions)) * (1 + len(layout.maps) * len(layout.tiles))
    with ThreadPoolExecutor(cores()) as pool, task("Reading the character", count) as done:
        character = _Loading(layout, sizes, pool, done).character(settings.placement)
    placeholders = {
        (name, (how.kind.name, tile))
        for how in layout.maps
        for (name, tile), path in how.files.items()
        if path in sizes.constants
    }
    return replace(character, notes=(*character.notes, *appearance.seen(character, placeholders)))


def save_folder(character: Character, folder: Path) -> None:
    """Write a folder; errors as of :func:`facezip.save_character`."""
    names, tiles = (NEUTRAL, *character.expressions), character.tiles
    with whole_folder(folder, False, None) as made, task("Writing the character", len(names)) as done:
        for name in names:
            write_obj(made / f"{name}.obj", character.mesh_vertices(name), character.meshes.topology)
            for kind in character.maps:
                for tile in tiles:
                    stem = made / file_name(name, kind, tile, tiles)
                    write_map(stem, character.texels(name, (kind.name, tile)), kind)
            done()
        if character.meshes.centimetres:
            (made / SETTINGS).write_text('unit = "cm"\n', encoding="utf-8")
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

    def __init__(self, layout: Layout, sizes: Sizes, pool: Executor, done: Callable[[], None]) -> None:
        self._layout, self._names, self._pool, self._done = layout, layout.expressions, pool, done
        self._sizes, self._notes = sizes, [*sizes.notes]
        self._meshes = FolderMeshes(layout, 1 / max(map(max, sizes.of.values())))

    def character(self, placement: Placement) -> Character:
        layout = self._layout
        self._masks: dict[int, NDArray[np.float32]] = {}
        for tile, path in layout.masks.items():
            self._masks[tile], done = read_face(path)
            self._notes += (layout.note(path, words) for words in done)
        # Their parsers leave the interpreter to other threads: meshes are read, and looked at, beside textures.
        neutral, self._topology = self._mesh(NEUTRAL)
        moved = [self._pool.submit(self._mesh, name) for name in self._names]
        standing = self._pool.submit(self._placed, neutral, moved, placement)
        maps: list[Map] = []
        stacks: dict[Key, Stack] = {}
        for how in layout.maps:
            kind, tiles = self._map(how)
            maps.append(kind)
            stacks |= {(kind.name, tile): stack for tile, stack in tiles.items()}
        meshes, done_to_them = standing.result()
        # Threads find them in any order.
        found = sorted([*self._meshes.notes, *self._notes], key=lambda note: (note.file, note.words))
        name = printable(layout.folder.resolve().name)
        return Character(name, self._names, meshes, tuple(maps), stacks, (*layout.notes, *found, *done_to_them))

    def _mesh(self, name: str) -> Mesh:
        mesh = self._meshes.in_order(name, self._meshes.read(name))
        self._done()
        return mesh

    def _placed(
        self, neutral: NDArray[np.float32], moved: list[Future[Mesh]], placement: Placement
    ) -> tuple[Meshes, tuple[Note, ...]]:
        # Those that it waits for were begun before it.
        vertices = np.stack([future.result()[0] for future in moved])
        return placed(Meshes(self._topology, neutral, vertices), self._names, placement, self._layout.folder)

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
        size = self._sizes.of[how.kind.name, tile]
        on_face = self._seen(tile, size) if how.kind.is_normal else None
        names = (NEUTRAL, *self._names)
        # What placeholders have to be like: the first that is none.
        whole = next((name for name in names if how.files[name, tile] not in self._sizes.constants), None)
        like = None if whole is None else self._texture(how, how.files[whole, tile], signed, on_face, tile)
        kept = {} if whole is None or like is None else {whole: like}

        def read(name: str, into: Texels | None = None) -> Texels:
            path = how.files[name, tile]
            if path in self._sizes.constants:
                value = self._texture(how, path, signed, None, tile)[0, 0]
                texture = constant(path, value, size, value if like is None else like, into)
            else:
                texture = kept.pop(name) if name in kept else self._texture(how, path, signed, on_face, tile, into)
            self._done()
            return texture

        neutral = read(NEUTRAL)
        textures: Texels = memory.empty((len(self._names), *neutral.shape), neutral.dtype)

        def fill(name: str, into: Texels) -> None:
            texture = read(name, into)
            if texture.shape != into.shape or texture.dtype != into.dtype:
                raise FaceZipError(
                    ErrorCode.SIZE_MISMATCH,
                    f"{how.files[name, tile]}: {described(texture)}, the neutral is {described(neutral)}; export both "
                    "alike",
                )
            if texture is not into:
                into[:] = texture

        list(self._pool.map(fill, self._names, textures))
        return Stack(neutral, textures, self._mask(how, tile, neutral.shape[:2]))

    def _texture(
        self,
        how: MapFiles,
        path: Path,
        signed: bool,
        on_face: NDArray[np.bool_] | None,
        tile: int,
        into: Texels | None = None,
    ) -> Texels:
        if how.kind.is_normal:
            some = np.ones(stated(path).size, np.bool_) if on_face is None else on_face
            return filled(normal_rows(path, how, signed, some), into)
        alpha = Extremes()
        texture = filled(value_rows(path, how, alpha), into)
        if not alpha.are_constant.all():
            words = "its alpha varies and is not used; if it is the mask of the face, save it as mask.png"
            self._notes.append(self._layout.note(path, words, asks=tile not in self._masks))
        return texture

    def _mask(self, how: MapFiles, tile: int, size: tuple[int, int]) -> NDArray[np.float32] | None:
        if tile not in self._masks:
            return None
        path, is_one_of_several = self._layout.masks[tile], len(self._layout.tiles) > 1
        mask, words = sized_for(how.kind.name, size, self._masks[tile], str(path), may_be_black=is_one_of_several)
        self._notes += [self._layout.note(path, words)] if words else []
        return mask

    def _seen(self, tile: int, size: tuple[int, int]) -> NDArray[np.bool_]:
        return seen(shifted(self._topology, tile), size, self._masks.get(tile))


def constant(
    path: Path, value: NDArray[Any], size: tuple[int, int], like: NDArray[Any], into: Texels | None = None
) -> Texels:
    """One texel ``(C,)`` as a texture of a size, in the channels and the type of another."""
    channels = like.shape[-1]
    if len(value) not in (1, channels) and not (value == value[0]).all():
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH, f"{path}: {len(value)} channels, the others have {channels}; export all alike"
        )
    texel = value if len(value) == channels else np.repeat(value[:1], channels)
    if like.dtype != value.dtype:
        texel = as_texels(to_float(texel), like.dtype)
    texture = memory.empty((*size, channels), like.dtype) if into is None or into.dtype != like.dtype else into
    texture[:] = texel
    return texture


def described(texture: Texels) -> str:
    """Size, channels and type of a texture."""
    height, width, channels = texture.shape
    return f"{words_for((height, width))} with {channels} channel(s) of {texture.dtype}"


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
