"""An animation for programs that cannot blend weight maps: β by frame, and weight maps blended beforehand."""

import csv
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import shorten

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.source import Tile
from facezip.names import one_form
from facezip.pack.model import MAX_BLEND

_log = logging.getLogger("facezip")

# β by name; what is not named is zero. With GAIN in front of a name, how strongly it changes textures, and with REGION,
# how strongly all that do change that region of the face: else 1.
Frame = Mapping[str, float]
GAINS = "gains."
GAIN, REGION = f"{GAINS}expressions.", f"{GAINS}regions."
# No animator asks for more of an expression; who counts in percents does.
_LARGEST = 10
_EXPECTED = "give a CSV file of weights: different names of expressions in its first row, then a row of numbers a frame"


def every_expression(expressions: Sequence[str]) -> list[Frame]:
    """The neutral, and then each expression in a frame of its own."""
    return [{}, *({name: 1.0} for name in expressions)]


def read_animation(path: Path) -> list[Frame]:
    """Frames of a CSV file: names of expressions, or of gains, in its first row; a row of numbers for every frame.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, or ``BAD_VALUE`` that names the line.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            names, *rows = [row for row in csv.reader(file) if row] or [[]]
    except FileNotFoundError:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such animation; {_EXPECTED}") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: not a readable CSV file ({error}); {_EXPECTED}") from None
    names = [one_form(name.strip()) for name in names]
    if not rows or len({*names}) < len(names):
        first = f"its first row '{_begin(names)}'"
        reason = f"{first} has a name twice" if rows else f"no row of weights follows {first}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {reason}; {_EXPECTED}")
    frames = [_frame(path, number, names, row) for number, row in enumerate(rows, 1)]
    weights = [weight for frame in frames for name, weight in frame.items() if not name.startswith(GAINS)]
    largest = max(map(abs, weights), default=0)
    if largest > _LARGEST:
        _log.warning("%s: weights reach %g, where 1 is the whole expression; divide percents by 100", path, largest)
    return frames


def check(frames: Sequence[Frame], expressions: Sequence[str], regions: Sequence[str], whose: str) -> None:
    """Raise ``UNKNOWN_NAME`` or ``BAD_VALUE`` for the first frame that a pack, exported with regions, cannot show."""
    known = {*expressions, *(GAIN + name for name in expressions), *(REGION + name for name in regions)}
    for frame in frames:
        for name, weight in frame.items():
            if name.startswith(REGION) and name not in known:
                region = name.removeprefix(REGION)
                raise FaceZipError(
                    ErrorCode.UNKNOWN_NAME, f"{whose}: no region '{region}'; add --region {region}=mask.png"
                )
            if name not in known:
                raise unknown("expression", name, expressions, whose)
            if not abs(weight) <= MAX_BLEND:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of '{name}': must lie within ±{MAX_BLEND}")


def blended(tile: Tile, frame: Frame) -> NDArray[np.float32]:
    """The weight map ``(h, w, R)`` of a frame, Σ_n gain_n · β_n · W_n, times the gains of regions where those are."""
    beta = np.array([frame.get(GAIN + name, 1.0) * frame.get(name, 0.0) for name in tile.expressions], np.float32)
    weights = np.tensordot(beta, tile.sheets[0].weights, axes=1).astype(np.float32)
    for name, mask in zip(tile.regions.names, tile.regions.masks, strict=True):
        weights *= 1 + np.float32(frame.get(REGION + name, 1.0) - 1) * (mask[..., None] / np.float32(255))
    return weights


def _frame(path: Path, number: int, names: Sequence[str], row: Sequence[str]) -> Frame:
    try:
        return {name: float(value) for name, value in zip(names, row, strict=True)}
    except ValueError:
        wanted = "a number" if len(names) == 1 else f"{len(names)} numbers"
        reason = f"row {number} of weights is '{_begin(row)}', not {wanted} as the first row '{_begin(names)}' asks for"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {reason}; {_EXPECTED}") from None


def _begin(row: Sequence[str]) -> str:
    """As much of a row as shows what kind of file it is of."""
    return shorten(",".join(row), 40, placeholder="…")
