"""Named regions of the face, which can be turned down after export: masks of a weight map's size, side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.export.documents.textures import ExportedRegions
from facezip.files.images import write_texture
from facezip.files.values import read_mask
from facezip.fit.given import as_bytes, resampled
from facezip.names import first_unusable
from facezip.pack.manifest import Manifest, TileEntry

FILE_NAME = "regions.png"
# Stands for a tile's number in the name of a mask's file.
UDIM = "<UDIM>"


@dataclass(frozen=True, eq=False)
class Regions:
    """The regions of a tile.

    Attributes
    ----------
    names : K of them.
    masks : ``(K, h, w)`` uint8 of a weight map's size: where a region is, 255 where it is wholly.
    """

    names: tuple[str, ...]
    masks: NDArray[np.uint8]

    @property
    def columns(self) -> int:
        """Masks beside each other in the image."""
        return isqrt(max(len(self.names) - 1, 0)) + 1

    @property
    def rows(self) -> int:
        """Masks below each other in the image."""
        return -(-len(self.names) // self.columns)

    def write(self, folder: Path) -> ExportedRegions | None:
        """Write the image, where there are regions, and say what a document says of it."""
        if not self.names:
            return None
        height, width = self.masks.shape[1:]
        image = np.zeros((self.rows * height, self.columns * width, 1), np.uint8)
        for k, mask in enumerate(self.masks):
            top, left = height * (k // self.columns), width * (k % self.columns)
            image[top : top + height, left : left + width, 0] = mask
        write_texture(folder / FILE_NAME, image)
        return ExportedRegions(file=FILE_NAME, columns=self.columns, size=(height, width))


def read_regions(pack: Path, manifest: Manifest, files: Mapping[str, Path]) -> dict[int, Regions]:
    """The regions of every tile of a pack, by its number.

    Parameters
    ----------
    pack, manifest : whose weight maps have the size of the masks.
    files : by name the image of a region, white where it is, of any size over the unit square of a tile. Of several
        tiles, its name has ``<UDIM>`` in the place of a tile's number; a tile without a file has nothing of the region.

    Raises
    ------
    FaceZipError
        ``UNSAFE_NAME``; ``BAD_VALUE`` where weights are uniform, or a file is not for one of several tiles;
        ``MISSING_FILE`` where no tile has one; ``BAD_TEXELS`` for a region that is nowhere; what
        :func:`facezip.files.values.read_mask` raises.
    """
    unusable = first_unusable(files)
    if unusable is not None:
        raise FaceZipError(ErrorCode.UNSAFE_NAME, f"--region {unusable}: choose another name for the region")
    if files and manifest.uniform_weights:
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{pack}: its weights are the same everywhere; regions need weight maps"
        )
    masks = [_masks(path, manifest.tiles) for path in files.values()]
    found = {}
    for t, tile in enumerate(manifest.tiles):
        of_tile = np.array([mask[t] for mask in masks], np.uint8)
        found[tile.number] = Regions(tuple(files), of_tile.reshape(-1, *tile.weight_size))
    return found


def _masks(path: Path, tiles: Sequence[TileEntry]) -> list[NDArray[np.uint8]]:
    """A region on each tile, averaged over each texel of a weight map, or between its own where it is smaller."""
    if len(tiles) > 1 and UDIM not in path.name:
        remedy = f"write {UDIM} in the place of the tile's number"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: is one image for several tiles; {remedy}")
    files = [path.with_name(path.name.replace(UDIM, str(tile.number))) for tile in tiles]
    if UDIM in path.name and not any(file.is_file() for file in files):
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no tile of the pack has such a file")
    masks = [_mask(file, tile.weight_size, UDIM in path.name) for file, tile in zip(files, tiles, strict=True)]
    if not any(mask.any() for mask in masks):
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: is black everywhere; paint the region white")
    return masks


def _mask(file: Path, size: tuple[int, int], may_be_missing: bool) -> NDArray[np.uint8]:
    if may_be_missing and not file.is_file():
        return np.zeros(size, np.uint8)
    mask, _ = read_mask(file)
    return as_bytes(resampled(mask, size)[None])[0]
