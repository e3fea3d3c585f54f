"""Masks that somebody gives: those of an engine's rig, or painted ones."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine import memory
from facezip.machine.rows import by_rows


@dataclass(frozen=True, eq=False)
class GivenMasks:
    """K masks, in which layers they may act, and what an engine does with their activations.

    Attributes
    ----------
    names : K names.
    images : by name and tile, ``(H, W)`` float32 in [0, 1], of any size; a mask is 0 on a tile that has none of it.
    layers : by name, the difference textures, from 0 on, in which a mask may act; in all where it is not named.
    nonnegative : whether activations lie in 0..1, as engines need that clamp them; otherwise they are free.
    sum_to_one : whether masks are divided by their sum, wherever that is not 0; otherwise they are taken as they are.
    """

    names: tuple[str, ...]
    images: Mapping[tuple[str, int], NDArray[np.float32]]
    layers: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    nonnegative: bool = False
    sum_to_one: bool = False

    def on_grids(self, sizes: Mapping[int, tuple[int, int]]) -> dict[int, NDArray[np.uint8]]:
        """The masks ``(K, h, w)`` on the weight maps' grids of all tiles, by their ``sizes`` ``(h, w)``.

        Raises
        ------
        FaceZipError
            ``UNKNOWN_NAME`` for an image on a tile that there is not, ``BAD_TEXELS`` for a mask that is 0 everywhere.
        """
        for name, tile in self.images:
            if tile not in sizes:
                there = ", ".join(map(str, sizes))
                raise FaceZipError(
                    ErrorCode.UNKNOWN_NAME, f"mask '{name}': there is no tile {tile}; the character has {there}"
                )
        grids = {tile: self._on_grid(tile, size) for tile, size in sizes.items()}
        for k, name in enumerate(self.names):
            if not any(grid[k].any() for grid in grids.values()):
                reason = f"black everywhere at the weight maps' {' and '.join(f'{w}x{h}' for h, w in sizes.values())}"
                raise FaceZipError(ErrorCode.BAD_TEXELS, f"mask '{name}': {reason} texels; paint it, or leave it out")
        return grids

    def allowed(self, slots: int) -> NDArray[np.bool_]:
        """``(K, R)``: whether a mask may act in a layer, of R = ``slots``.

        Raises
        ------
        FaceZipError
            ``BAD_VALUE`` for a layer that there is not, or one in which no mask may act.
        """
        every = tuple(range(slots))
        for name, layers in self.layers.items():
            if not layers or not {*layers} <= {*every}:
                reason = f"layers {list(layers)}: there are 0 to {slots - 1}, by --differences; name some of them"
                raise FaceZipError(ErrorCode.BAD_VALUE, f"mask '{name}': {reason}")
        allowed = np.array([np.isin(every, self.layers.get(name, every)) for name in self.names])
        if not allowed.any(axis=0).all():
            unused = int(allowed.any(axis=0).argmin())
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"layer {unused}: no mask may act in it; ask for fewer --differences"
            )
        return allowed

    def _on_grid(self, tile: int, size: tuple[int, int]) -> NDArray[np.uint8]:
        values: NDArray[np.float32] = memory.zeros((len(self.names), *size), np.float32)
        for k, name in enumerate(self.names):
            if (name, tile) in self.images:
                values[k] = resampled(self.images[name, tile], size)
                memory.ease()
        return as_bytes(
            by_rows(lambda rows: _shares(values[:, rows]), values.shape, np.float32, axis=1)
            if self.sum_to_one
            else values
        )


def as_bytes(masks: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Masks ``(K, h, w)`` in [0, 1] as a pack stores them."""

    def rounded(rows: slice) -> NDArray[np.uint8]:
        return np.rint(np.clip(masks[:, rows], 0, 1) * np.float32(255)).astype(np.uint8)

    return by_rows(rounded, masks.shape, np.uint8, axis=1)


def _shares(masks: NDArray[np.float32]) -> NDArray[np.float32]:
    """Masks ``(K, h, w)`` divided by their sum, where that is not 0."""
    total = masks.sum(axis=0)
    return np.divide(masks, total, out=masks.copy(), where=total > 0)


def resampled(image: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """An image ``(H, W)`` at another size ``(h, w)``: means of what a texel covers, or values between texels."""
    (height, width), (h, w) = image.shape, size
    if height * width <= h * w:
        return np.array(Image.fromarray(image).resize((w, h), Image.Resampling.BILINEAR))

    def means(rows: slice) -> NDArray[np.float32]:
        above, below = rows.start * height / h, rows.stop * height / h
        first, end = int(above), min(ceil(below), height)
        band = Image.fromarray(np.ascontiguousarray(image[first:end]))
        box = (0, above - first, width, min(below, height) - first)
        return np.array(band.resize((w, rows.stop - rows.start), Image.Resampling.BOX, box))

    return by_rows(means, size, np.float32)
