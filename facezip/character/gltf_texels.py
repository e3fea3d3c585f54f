"""Rows of a glTF's textures as the numbers that are fitted: colours times a factor, the green of roughness, normals."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.layout import MapFiles
from facezip.character.maps import KNOWN
from facezip.character.texels import normal_rows
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import Bands, sliced
from facezip.files.colours import narrow
from facezip.files.decoding import decoding
from facezip.files.images import Texels, to_float
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.machine.rows import BLOCK

NOTHING = (1.0, 1.0, 1.0)


def tinted(bands: Bands, tint: tuple[float, float, float], coloured: bool) -> Bands:
    """Encoded colours times ``tint``, in linear light, of the same type; grey as three channels where ``coloured``."""
    if tint == NOTHING and not coloured:
        yield from bands
        return
    tables: dict[np.dtype[np.unsignedinteger], Texels] = {}
    for top, height, band in sliced(bands, BLOCK):
        colours = np.repeat(band, 3, axis=2) if coloured and band.shape[2] == 1 else band
        channels = colours.shape[2]
        if colours.dtype.kind == "f":
            yield top, height, _times(colours, tint[:channels])
            continue
        if colours.dtype not in tables:
            every = np.arange(np.iinfo(colours.dtype).max + 1, dtype=colours.dtype)
            light = _times(to_float(np.repeat(every[:, None, None], 3, axis=2)), tint)[:, 0]
            tables[colours.dtype] = np.rint(light * np.float32(every[-1])).astype(colours.dtype)
        yield top, height, np.stack([tables[colours.dtype][colours[..., c], c] for c in range(channels)], axis=2)


def _times(colours: NDArray[np.float32], tint: tuple[float, ...]) -> NDArray[np.float32]:
    return encode_srgb(decode_srgb(colours) * np.array(tint, np.float32))


def roughness_rows(path: Path, factor: float) -> Bands:
    """The green channel, in which glTF has roughness, times a factor; ``(H, W, 1)``."""
    with decoding(path) as (facts, bands):
        for top, height, band in sliced(bands, BLOCK):
            channels = narrow(facts.without_alpha(band))
            stored = channels[:, :, min(1, channels.shape[2] - 1), None]
            if factor != 1:
                scaled = stored * np.float32(factor)
                stored = scaled if stored.dtype.kind == "f" else np.rint(scaled).astype(stored.dtype)
            yield top, height, stored


def bumped_rows(path: Path, factor: float, seen: NDArray[np.bool_]) -> Bands:
    """Normals as slopes ``(H, W, 2)``, times the factor of x and y; ``seen`` as of :func:`normal_rows`.

    Raises
    ------
    FaceZipError
        What :func:`facezip.character.texels.normal_rows` raises, also for what the factor makes too steep.
    """
    half = np.float32(0.5)
    for top, height, slopes in normal_rows(path, MapFiles(KNOWN["normal"]), False, seen):
        if factor == 1:
            yield top, height, slopes
            continue
        scaled = half + np.float32(factor) * (to_float(slopes) - half)
        steep = np.abs(scaled - half).max(axis=2) > half
        if (steep & seen[top : top + len(steep)]).any():
            reason = f"normals times their scale of {factor:.3g} are steeper than 84 degrees; export it with less"
            raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: {reason}")
        scaled[steep] = half
        yield top, height, scaled if slopes.dtype.kind == "f" else np.rint(scaled * 65535).astype(slopes.dtype)
