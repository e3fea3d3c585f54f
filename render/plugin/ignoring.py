"""Regions of an image that do not count: a clock, a logo, a machine's name."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import read_texture, to_float

# An image file, or what picks pixels of an (H, W) array: True where ignored, or slices.
Region = str | Path | Any


def ignored_pixels(region: Region, shape: tuple[int, int]) -> NDArray[np.bool_] | None:
    """``(H, W)``, True where a pixel does not count; None where all do.

    Parameters
    ----------
    region : None; an image file, white where ignored; an ``(H, W)`` array, True or above 0.5 there; slices, such as
        ``np.s_[:16, :]`` for the 16 uppermost rows; or a list of these, which are joined.
    shape : ``(H, W)`` of the image.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``: it has another shape; ``BAD_VALUE``: it picks nothing, or leaves nothing, or is no region.
    """
    if region is None:
        return None
    mask = np.zeros(shape, bool)
    for one in region if isinstance(region, list) else [region]:
        mask |= _mask(one, shape)
    if mask.all() or not mask.any():
        count = "every pixel" if mask.all() else "no pixel"
        reason = f"ignore= picks {count} of {shape[1]} x {shape[0]}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{reason}; give the region that may differ")
    return mask


def _mask(region: Region, shape: tuple[int, int]) -> NDArray[np.bool_]:
    if isinstance(region, str | Path):
        region = to_float(read_texture(Path(region)))[..., :3].mean(axis=2)
    if isinstance(region, np.ndarray):
        if region.shape != shape:
            reason = f"ignore= has the shape {region.shape}, the image {shape}"
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{reason}; give it one value for every pixel")
        return np.asarray(region > 0.5)
    mask = np.zeros(shape, bool)
    try:
        mask[region] = True
    except (IndexError, TypeError):
        reason = f"ignore= is no region: {type(region).__name__}"
        message = f"{reason}; give a file, an array of the image's size, or slices"
        raise FaceZipError(ErrorCode.BAD_VALUE, message) from None
    return mask
