"""A small, smooth registration in UV: every expression's texture moved onto the neutral's, and by how much."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character.alignment import Alignment, Alignments
from facezip.character.displacement import bilinear
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.files.images import Texels
from facezip.machine.kernels import inner, kernel
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows

# Standard deviation of the smoothing of a displacement, in cells of its grid.
SMOOTHING = 1.0
# Resampling blurs a little: what lies this well, in texels of a texture of 512 x 512, is not touched.
LEAST = 0.25


def register(character: Character, found: Alignments) -> tuple[Character, tuple[str, ...]]:
    """Move the texels of all maps back by the displacements that were found on the albedo; meshes and UVs stay.

    Returns
    -------
    The character, and the names of the expressions that were moved: those off by more than ``LEAST`` on some tile.
    """
    moved = tuple(name for name, tiles in found.items() if any(map(_is_off, tiles.values())))
    if not moved:
        return character, moved
    stacks = {key: replace(stack, textures=_copied(stack.textures)) for key, stack in character.stacks.items()}
    for name in track(moved, "Registering", len(moved)):
        n = character.index(name)
        for (_, tile), stack in stacks.items():
            alignment = found[name][tile]
            if _is_off(alignment):
                # Of an albedo's texels, as many of a finer map are as far.
                size = character.stacks[ALBEDO, tile].resolution
                finer = np.array([stack.resolution[1] / size[1], stack.resolution[0] / size[0]], np.float32)
                displacement, most = smoothed(alignment) * finer, float(np.rint(1 / stack.scale))
                stack.textures[n] = _moved(np.ascontiguousarray(stack.textures[n]), displacement, most)
    return replace(character, stacks=stacks), moved


def _copied(textures: Texels) -> Texels:
    return by_rows(lambda rows: textures[:, rows], textures.shape, textures.dtype, axis=1)


def _is_off(alignment: Alignment) -> bool:
    return alignment.rms > LEAST * alignment.unit


def smoothed(alignment: Alignment) -> NDArray[np.float32]:
    """The displacement ``(32, 32, 2)`` where it is sure, carried on smoothly where it is not, to nothing far away."""
    sure = alignment.confidence[:, :, None].astype(np.float64)
    weighted = gaussian_filter(sure * alignment.displacement, (SMOOTHING, SMOOTHING, 0), mode="nearest")
    known = gaussian_filter(sure, (SMOOTHING, SMOOTHING, 0), mode="nearest")
    return (weighted / (known + 0.02)).astype(np.float32)


def _moved(texture: Texels, displacement: NDArray[np.float32], most: float) -> Texels:
    """The texture ``(H, W, C)`` read at p + u(p), by Catmull and Rom's cubic, in its own type."""
    out = np.empty_like(texture)
    rounding = 0.0 if texture.dtype.kind == "f" else 0.5

    def rows(top: int, bottom: int) -> None:
        _read_at(top, bottom, texture, displacement, most, rounding, out)

    map_rows(rows, len(texture))
    return out


@kernel()
def _read_at(
    top: int,
    bottom: int,
    texture: NDArray[np.uint8],
    displacement: NDArray[np.float32],
    most: float,
    rounding: float,
    out: NDArray[np.uint8],
) -> None:
    height, width, channels = texture.shape
    cells = displacement.shape[0]
    across, down = np.empty(4), np.empty(4)
    for y in range(top, bottom):
        gy = (y + 0.5) * cells / height - 0.5
        for x in range(width):
            gx = (x + 0.5) * cells / width - 0.5
            at_x = x + bilinear(displacement[:, :, 0], gx, gy)
            at_y = y + bilinear(displacement[:, :, 1], gx, gy)
            left, upper = int(np.floor(at_x)), int(np.floor(at_y))
            _cubic(at_x - left, across)
            _cubic(at_y - upper, down)
            for c in range(channels):
                total = 0.0
                for j in range(4):
                    row = min(max(upper - 1 + j, 0), height - 1)
                    for i in range(4):
                        column = min(max(left - 1 + i, 0), width - 1)
                        total += down[j] * across[i] * texture[row, column, c]
                out[y, x, c] = min(max(total, 0.0), most) + rounding


@inner()
def _cubic(t: float, out: NDArray[np.float64]) -> None:
    """Weights of the four texels around a place."""
    out[0] = t * (-0.5 + t * (1.0 - 0.5 * t))
    out[1] = 1.0 + t * t * (-2.5 + 1.5 * t)
    out[2] = t * (0.5 + t * (2.0 - 1.5 * t))
    out[3] = t * t * (-0.5 + 0.5 * t)
