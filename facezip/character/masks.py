"""The face region of a tile: the image that is its mask, in the sizes of the tile's maps."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.character.raster import covered
from facezip.character.sizes import words_for
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology
from facezip.files.statements import stated
from facezip.files.values import read_mask
from facezip.machine.rows import by_rows

Mask = NDArray[np.float32]

# Texels each way in which a mask is held against a chart.
SIDE = 256
# A mask that is white on so much of what is beside the chart, and on less than so much of the chart, has them swapped.
WHITE_BESIDE, WHITE_ON = 0.9, 0.5


def read_face(path: Path) -> tuple[Mask, tuple[str, ...]]:
    """A mask ``(H, W)`` in [0, 1], and what was done to its image, in words; raises as ``files.values.read_mask``."""
    mask, channel = read_mask(path)
    words = stated(path).applied(as_colours=False)
    return mask, (*words, f"its channel {channel} is the mask") if channel else words


def sized_for(kind: str, size: tuple[int, int], mask: Mask, what: str, may_be_black: bool = False) -> tuple[Mask, str]:
    """The mask of a map's texels, and what was done to it, in words.

    It has the albedo's size, or one value; other maps may be finer or coarser.

    Parameters
    ----------
    kind : the name of the map.
    size : rows and columns of its textures.
    mask, what : ``(H, W)``, and the image that it is of, for messages.
    may_be_black : whether the tile, one of several, need not show any of the face.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH`` for another size than the albedo's, ``BAD_TEXELS`` for a mask that is black everywhere.
    """
    words = ""
    if mask.shape != size:
        mine = words_for((mask.shape[0], mask.shape[1]))
        if kind == ALBEDO and mask.min() < mask.max():
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{what}: {mine}, the textures differ; resize the mask")
        if kind == ALBEDO:
            words = f"{mine} of one value; taken for that constant, {words_for(size)}"
        mask = nearest(mask, size)
    if not may_be_black and not mask.any():
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{what}: the mask is black everywhere; paint the face region white")
    return mask, words


def seen(chart: Topology, size: tuple[int, int], mask: Mask | None) -> NDArray[np.bool_]:
    """Texels ``size`` on the mesh, within the mask of any size where there is one."""
    on_mesh = covered(chart, size)
    if mask is None:
        return on_mesh
    inside = nearest(mask, size)
    return by_rows(lambda rows: on_mesh[rows] & (inside[rows] > 0), size, np.bool_)


def is_swapped(chart: Topology, mask: Mask) -> bool:
    """Whether a mask ``(H, W)`` is white about the mesh's chart and mostly black on it, as one is that was inverted."""
    on_mesh, values = covered(chart, (SIDE, SIDE)), nearest(mask, (SIDE, SIDE))
    if on_mesh.all() or not on_mesh.any():
        return False
    return bool(values[~on_mesh].mean() > WHITE_BESIDE and values[on_mesh].mean() < WHITE_ON)


def nearest(image: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """An image ``(H, W)`` at another size ``(h, w)``: the texel in which the centre of each lies, ⌊(2i + 1) H / 2h⌋."""
    if image.shape == size:
        return image
    down, across = ((2 * np.arange(to) + 1) * of // (2 * to) for to, of in zip(size, image.shape, strict=True))
    return by_rows(lambda rows: image[down[rows]][:, across], size, np.float32)
