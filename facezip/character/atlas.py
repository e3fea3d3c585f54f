"""UDIM tiles side by side in one texture, for whoever looks at a single unit square of UV."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import zoom

from facezip.character.surface import FIRST_TILE
from facezip.files.obj import Topology


@dataclass(frozen=True)
class Atlas:
    """The smallest grid of tiles that holds some.

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
        across, up = ([divmod(tile - FIRST_TILE, 10)[k] for tile in tiles] for k in (1, 0))
        return cls(min(across), min(up), max(across) - min(across) + 1, max(up) - min(up) + 1)

    def topology(self, topology: Topology) -> Topology:
        """A UV layout over tiles, moved and scaled into the unit square."""
        if self == Atlas(0, 0, 1, 1):
            return topology
        origin, size = np.array([self.left, self.below]), np.array([self.columns, self.rows])
        return replace(topology, uv=((topology.uv - origin) / size).astype(np.float32))

    def joined(self, textures: Mapping[int, NDArray[np.float32]]) -> NDArray[np.float32]:
        """Textures ``(H, W, C)`` by tile as one, ``(rows·H, columns·W, C)``; smaller ones are enlarged to the largest.

        Neighbours lie beside each other as on the mesh, so that a bilinear look over a border sees what is there.
        """
        height, width, channels = np.max([texture.shape for texture in textures.values()], axis=0)
        whole = np.zeros((self.rows * height, self.columns * width, channels), np.float32)
        for tile, texture in textures.items():
            up, across = divmod(tile - FIRST_TILE, 10)
            top, left = (self.rows - 1 - (up - self.below)) * height, (across - self.left) * width
            whole[top : top + height, left : left + width] = _enlarged(texture, height, width)
        return whole


def _enlarged(texture: NDArray[np.float32], height: int, width: int) -> NDArray[np.float32]:
    if texture.shape[:2] == (height, width):
        return texture
    factors = height / texture.shape[0], width / texture.shape[1], 1
    larger: NDArray[np.float32] = zoom(texture, factors, order=1, mode="nearest", grid_mode=True)
    return larger
