"""What is kept of an older pack: masks of regions as images, and whether the pack is one of these scans."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.values import read_mask
from facezip.fit.given import resampled
from facezip.fit.kept import KeptRegion
from facezip.machine import memory
from facezip.machine.rows import by_rows
from facezip.pack.manifest import Manifest
from facezip.pack.read import read_bytes
from facezip.pack.same_neutral import check_same_neutral

# Of a soft mask, what belongs to a region.
INSIDE = np.float32(0.5)

_NAME = re.compile(r"(?P<region>.+?)(?:\.(?P<tile>1\d{3}))?", re.DOTALL)


@dataclass(frozen=True)
class Keeping:
    """What is asked for.

    Attributes
    ----------
    pack : the older pack.
    images : masks of regions by name, ``forehead`` or ``forehead.1002``.
    names : the regions that stay.
    """

    pack: Path
    images: Mapping[str, Path] = field(default_factory=dict)
    names: tuple[str, ...] = ()

    @property
    def stated(self) -> dict[str, object]:
        """What a pack says of it."""
        return {"pack": self.pack.name, "regions": list(self.names)}


def read_kept(keeping: Keeping, character: Character, differences: int, weight_scale: int) -> KeptRegion:
    """The regions of an older pack that stay.

    Parameters
    ----------
    keeping : which.
    character : the scans that are fitted.
    differences, weight_scale : how many difference textures are asked for, and how many times smaller weight maps.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` and :func:`facezip.pack.same_neutral.check_same_neutral` raise; ``BAD_VALUE`` for
        a pack without weight maps, or of other settings, or a region without its tile; ``MISSING_FILE``,
        ``UNKNOWN_NAME`` and ``BAD_TEXELS`` for a mask that is none, or in which nothing is inside.
    """
    manifest, stored = read_bytes(keeping.pack)
    _check_settings(keeping.pack, manifest, differences, weight_scale)
    model = stored.dequantised()
    check_same_neutral(character, stored, model, keeping.pack)
    if stored.maps != character.maps:
        reason = f"its maps have other ranges than those of {character.name}; give both with or without --float"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{keeping.pack}: {reason}")
    masks = [(_tile(name, keeping.names, character), _mask(name, file)) for name, file in keeping.images.items()]
    inside = {
        key: _inside([mask for tile, mask in masks if tile == key[1]], stack.resolution)
        for key, stack in character.stacks.items()
    }
    if not any(own.any() for own in inside.values()):
        files = ", ".join(str(file) for file in keeping.images.values())
        reason = f"nothing is inside {' and '.join(keeping.names)}, where a mask is at least half white; paint it"
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{files}: {reason}")
    return KeptRegion(keeping.names, stored, model, inside, manifest.made_with.get("nonnegative") is True)


def _check_settings(pack: Path, manifest: Manifest, differences: int, weight_scale: int) -> None:
    if manifest.masks or manifest.uniform_weights:
        what = "masks" if manifest.masks else "one number an expression"
        reason = f"its weights are {what}, which no region has to itself; keep one of a pack with weight maps"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {reason}")
    tile = manifest.tiles[0]
    theirs = len(tile.weight_span)
    if theirs != differences:
        reason = f"has {theirs} difference textures, and this fit {differences}: give --differences {theirs}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {reason}")
    scale = manifest.footprint.weight_scale
    if scale != weight_scale:
        remedy = (
            f"give --weight-scale {scale}" if scale else "keep one whose weight maps are of a size that a fit makes"
        )
        reason = f"its weight maps have another size than those of this fit: {remedy}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {reason}")


def _tile(name: str, kept: tuple[str, ...], character: Character) -> int:
    """That on which a mask of a region, by its name, is."""
    match = None if name in kept else _NAME.fullmatch(name)
    region, number = (match["region"], match["tile"]) if match else (name, None)
    if number is None and len(character.tiles) > 1:
        there = ", ".join(map(str, character.tiles))
        reason = f"there are tiles {there}; name one of them too, as {region}.{character.tiles[0]}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--region '{name}': {reason}")
    return character.tile(int(number) if number else None)


def _inside(masks: Sequence[NDArray[np.float32]], size: tuple[int, int]) -> NDArray[np.bool_]:
    """``(H, W)``: where any mask, of whatever size, is at least half white."""
    seen = [resampled(mask, size) for mask in masks]

    def rows_of(rows: slice) -> NDArray[np.bool_]:
        return np.any([mask[rows] >= INSIDE for mask in seen], axis=0)

    return by_rows(rows_of, size, np.bool_) if seen else memory.zeros(size, np.bool_)


def _mask(name: str, file: Path) -> NDArray[np.float32]:
    if not file.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{file}: no such image; --region takes a mask, {name}=FILE")
    mask, _ = read_mask(file)
    return mask
