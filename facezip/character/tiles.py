"""UDIM tiles: unit squares of UV, numbered 1001 + column + 10 · row, each with textures of its own."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facezip.files.obj import Topology
from facezip.machine import memory

# Without UDIM, everything lies in the first tile.
FIRST_TILE = 1001
LAST_TILE = 1999


def place_of(tile: int) -> tuple[int, int]:
    """Column and row of a tile, from (0, 0) at the lower left."""
    row, column = divmod(tile - FIRST_TILE, 10)
    return column, row


def shifted(topology: Topology, tile: int) -> Topology:
    """The UV layout moved so that a tile lies in the unit square."""
    if tile == FIRST_TILE:
        return topology
    return replace(topology, uv=topology.uv - np.array(place_of(tile), np.float32))


def tiles_of_faces(topology: Topology, tiles: Sequence[int]) -> NDArray[np.intp]:
    """For each face the place in ``tiles`` of the one that it lies on, ``(F,)``, by the middle of its corners.

    Faces that lie on none of them go to the nearest, so that none is lost.
    """
    middles = topology.uv[topology.face_uv].mean(axis=1)
    nearest, least = np.zeros(len(middles), np.intp), np.full(len(middles), np.inf)
    for number, tile in enumerate(tiles):
        # In squares: a face on a tile is less than half a side from its middle, and from that of no other.
        column, row = place_of(tile)
        distance = np.abs(middles - (column + 0.5, row + 0.5)).max(axis=1)
        nearest[distance <= least] = number
        least = np.minimum(distance, least)
    return nearest


def charts(topology: Topology, tiles: Sequence[int]) -> list[Topology]:
    """The faces that lie on each tile (:func:`tiles_of_faces`), with that tile in the unit square."""
    places, found = tiles_of_faces(topology, tiles), []
    for number, tile in enumerate(tiles):
        own = places == number
        part = replace(topology, faces=topology.faces[own], face_uv=topology.face_uv[own])
        found.append(shifted(part, tile))
    return found


@dataclass(frozen=True)
class Atlas:
    """The smallest grid of tiles that holds some, as one texture for whoever looks at a single unit square of UV.

    Attributes
    ----------
    left, below : column and row of its first tile.
    columns, rows : how many.
    """

    left: int
    below: int
    columns: int
    rows: int

    @classmethod
    def of(cls, tiles: tuple[int, ...]) -> "Atlas":
        """The grid around UDIM numbers."""
        across, up = ([place_of(tile)[k] for tile in tiles] for k in (0, 1))
        return cls(min(across), min(up), max(across) - min(across) + 1, max(up) - min(up) + 1)

    def topology(self, topology: Topology) -> Topology:
        """A UV layout over tiles, moved and scaled into the unit square."""
        if self == Atlas(0, 0, 1, 1):
            return topology
        origin, size = np.array([self.left, self.below]), np.array([self.columns, self.rows])
        return replace(topology, uv=((topology.uv - origin) / size).astype(np.float32))

    def size(self, sizes: Iterable[tuple[int, int]]) -> tuple[int, int]:
        """Rows and columns of :meth:`joined` of textures of these sizes."""
        height, width = np.max([*sizes], axis=0).tolist()
        return self.rows * height, self.columns * width

    def joined(self, textures: Mapping[int, NDArray[np.float32]]) -> NDArray[np.float32]:
        """Textures ``(H, W, C)`` by tile as one, ``(rows·H, columns·W, C)``; smaller ones are enlarged to the largest.

        Neighbours lie beside each other as on the mesh, so that a bilinear look over a border sees what is there.
        """
        if len(textures) == 1 == self.rows * self.columns:
            return next(iter(textures.values()))
        height, width, channels = np.max([texture.shape for texture in textures.values()], axis=0)
        whole: NDArray[np.float32] = memory.zeros((self.rows * height, self.columns * width, channels), np.float32)
        for tile, texture in textures.items():
            column, row = place_of(tile)
            top, left = (self.rows - 1 - (row - self.below)) * height, (column - self.left) * width
            whole[top : top + height, left : left + width] = _enlarged(texture, height, width)
        return whole

    def summed(
        self, whole: NDArray[np.float32], sizes: Mapping[int, tuple[int, int]]
    ) -> dict[int, NDArray[np.float32]]:
        """Sums ``(rows·H, columns·W)`` of the texels of :meth:`joined` as those of each tile, ``(h, w)`` of its size.

        A texel that was enlarged has what all that it became have.
        """
        height, width = len(whole) // self.rows, whole.shape[1] // self.columns
        found = {}
        for tile, (h, w) in sizes.items():
            column, row = place_of(tile)
            top, left = (self.rows - 1 - (row - self.below)) * height, (column - self.left) * width
            part = whole[top : top + height, left : left + width]
            if part.shape != (h, w):
                part = (_overlaps(h, height) @ part @ _overlaps(w, width).T).astype(np.float32)
            found[tile] = part
        return found


def _overlaps(few: int, many: int) -> NDArray[np.float32]:
    """``(few, many)``: how much of each of the many cells of a line lies in each of the few."""
    ends = np.arange(many + 1) * (few / many)
    inside = np.minimum(ends[1:], np.arange(1, few + 1)[:, None]) - np.maximum(ends[:-1], np.arange(few)[:, None])
    return (np.maximum(inside, 0) * (many / few)).astype(np.float32)


def _enlarged(texture: NDArray[np.float32], height: int, width: int) -> NDArray[np.float32]:
    if texture.shape[:2] == (height, width):
        return texture
    # Not above: `facezip info` knows of tiles, and enlarges nothing.
    from scipy.ndimage import zoom

    factors = height / texture.shape[0], width / texture.shape[1], 1
    larger: NDArray[np.float32] = zoom(texture, factors, order=1, mode="nearest", grid_mode=True)
    return larger
