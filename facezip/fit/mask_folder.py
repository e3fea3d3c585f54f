"""Given masks as a folder: one image a mask, or one for several in its channels, and ``masks.toml``."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import filled
from facezip.files.decoding import decoding
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES, not_read
from facezip.files.reading import reading
from facezip.files.values import read_mask
from facezip.fit.given import GivenMasks
from facezip.machine.rows import by_rows, map_rows
from facezip.names import MAX_CHARACTERS, first_unusable

SETTINGS = "masks.toml"
MAX_SETTINGS = 2**20

_STEM = re.compile(r"(?P<name>.+?)(\.(?P<tile>1\d{3}))?", re.DOTALL)
_ACTIVATIONS = {"free": False, "0..1": True}


def read_masks(folder: Path) -> GivenMasks:
    """The masks of a folder (docs/given-masks.md).

    ``NAME.png`` is the mask NAME, of any size and of any format that is read; ``NAME.1002.png`` that of another tile.
    ``masks.toml`` says what is not ordinary.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` for no folder or no mask in it, ``BAD_VALUE`` for a ``masks.toml`` that says something else
        than it may, or two images of one mask, ``UNSAFE_NAME``, ``BAD_TEXELS`` for values outside [0, 1], and what
        images raise.
    """
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such folder; give one with an image for each mask")
    with reading(folder):
        said = _settings(folder / SETTINGS)
        files = [path for path in sorted(folder.iterdir()) if not path.name.startswith(".")]
    images: dict[tuple[str, int], NDArray[np.float32]] = {}
    for path in files:
        for key, image in _masks_of(path, said.channels):
            if key in images:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: a second image of mask '{key[0]}'; remove one")
            images[key] = image
    names = tuple(dict.fromkeys(name for name, _ in images))
    _check_names(folder, names, said)
    layers = {name: tuple(some) for name, some in said.layers.items()}
    return GivenMasks(names, images, layers, _ACTIVATIONS[said.activations], said.sum_to_one)


@dataclass(frozen=True)
class _Settings:
    """What ``masks.toml`` says, with what holds where it says nothing.

    Attributes
    ----------
    activations : one of :data:`_ACTIVATIONS`.
    sum_to_one : whether masks are divided by their sum, wherever that is not 0.
    layers : by mask, the layers in which it acts.
    channels : by image, the masks in its channels.
    """

    activations: str = "free"
    sum_to_one: bool = False
    layers: Mapping[str, Sequence[int]] = field(default_factory=dict)
    channels: Mapping[str, Sequence[str]] = field(default_factory=dict)


def _settings(path: Path) -> _Settings:
    if not path.is_file():
        return _Settings()
    if path.stat().st_size > MAX_SETTINGS:
        raise FaceZipError(ErrorCode.TOO_LARGE, f"{path}: larger than {MAX_SETTINGS} bytes")
    try:
        document = tomllib.loads(path.read_bytes().decode())
    except (ValueError, RecursionError) as error:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: not TOML ({error})") from None
    known: dict[str, tuple[Callable[[Any], bool], str]] = {
        "activations": (lambda value: value in [*_ACTIVATIONS], " or ".join(f'"{word}"' for word in _ACTIVATIONS)),
        "sum_to_one": (lambda value: type(value) is bool, "true or false"),
        "layers": (lambda value: _are_lists(value, int), "for each mask a list of layers, such as [0, 1]"),
        "channels": (lambda value: _are_lists(value, str), 'for each image the names of its channels, such as ["a"]'),
    }
    for name, value in document.items():
        if name not in known:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: '{name}' is not known; it has {', '.join(known)}")
        is_right, words = known[name]
        if not is_right(value):
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {name} has to be {words}")
    return _Settings(**document)


def _are_lists(value: Any, kind: type) -> bool:
    lists = value.values() if isinstance(value, dict) else [None]
    return all(isinstance(some, list) and all(type(item) is kind for item in some) for some in lists)


def _masks_of(
    path: Path, channels: Mapping[str, Sequence[str]]
) -> Iterator[tuple[tuple[str, int], NDArray[np.float32]]]:
    """The masks of a file, by name and tile; none of a file that is no image."""
    if path.suffix.lower() in OTHER_SUFFIXES:
        raise not_read(path)
    stem = _STEM.fullmatch(path.stem)
    if path.suffix.lower() not in TEXTURE_SUFFIXES or stem is None:
        return
    name, tile = stem["name"], int(stem["tile"] or FIRST_TILE)
    if name not in channels:
        yield (name, tile), _one_mask(path)
        return
    texels = _channels(path, len(channels[name]))
    for channel, each in enumerate(channels[name]):
        if each:
            yield (each, tile), by_rows(partial(_channel, texels, channel), texels.shape[:2], np.float32)


def _one_mask(path: Path) -> NDArray[np.float32]:
    try:
        mask, _ = read_mask(path)
        return mask
    except FaceZipError as error:
        if error.code is not ErrorCode.BAD_TEXELS or "channel" not in str(error):
            raise
        hint = f"or name its masks under [channels] in {SETTINGS}"
        raise FaceZipError(error.code, f"{error}, {hint}") from None


def _channels(path: Path, count: int) -> NDArray[np.float32]:
    """``(H, W, C)`` in [0, 1], as they are stored."""
    with decoding(path) as (facts, bands):
        texels = filled(bands)
    if facts.alpha == "associated":
        reason = (
            "its colours are multiplied by its alpha; masks in channels need a file where they are not, such as PNG"
        )
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: {reason}")
    if texels.shape[2] < count:
        reason = f"{texels.shape[2]} channels; {SETTINGS} names {count}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {reason}")
    whole = np.float32(1 if facts.is_float else np.iinfo(texels.dtype).max)
    values = by_rows(lambda rows: texels[rows].astype(np.float32) / whole, texels.shape, np.float32)
    if not all(map_rows(lambda top, bottom: _are_of_a_mask(values[top:bottom]), len(values))):
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: values outside 0..1; a mask lies within, rescale it")
    return values


def _are_of_a_mask(values: NDArray[np.float32]) -> bool:
    return bool(np.isfinite(values).all() and values.min() >= 0 and values.max() <= 1)


def _channel(texels: NDArray[np.float32], channel: int, rows: slice) -> NDArray[np.float32]:
    return texels[rows, :, channel]


def _check_names(folder: Path, names: tuple[str, ...], said: _Settings) -> None:
    if not names:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no image in it; give a folder with one for each mask")
    unusable = first_unusable(names)
    if unusable is not None:
        reason = f"mask '{unusable[:MAX_CHARACTERS]}' cannot be called so, or is there twice; rename it"
        raise FaceZipError(ErrorCode.UNSAFE_NAME, f"{folder}: {reason}")
    for name in said.layers:
        if name not in names:
            there = ", ".join(names)
            raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"{folder / SETTINGS}: no mask '{name}'; there are {there}")
