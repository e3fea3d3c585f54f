"""What every export starts from: a verified pack, and which of its texels the surface shows."""

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from facezip.errors import ErrorCode, FaceZipError
from facezip.manifest import Manifest
from facezip.model import CompressedTextures, Meshes
from facezip.pack import read_stored, verify_pack
from facezip.quantise import ZERO, QuantisedMaps, dequantise
from facezip.raster import rasterise
from facezip.textures import Texels

Kind = TypeVar("Kind", np.uint8, np.uint16, np.float32)


@dataclass(frozen=True, eq=False)
class Source:
    """A pack to export.

    Attributes
    ----------
    path : its folder.
    manifest : its manifest.
    maps : its maps as they are stored.
    model : the same as values.
    covered : ``(H, W)``, whether a texel's centre lies in the UV chart; everywhere where the pack has no mesh.
    """

    path: Path
    manifest: Manifest
    maps: QuantisedMaps
    model: CompressedTextures
    covered: NDArray[np.bool_]

    @property
    def meshes(self) -> Meshes:
        """The geometry; ``BAD_VALUE`` where the pack has none."""
        if self.model.meshes is None:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{self.path}: has no meshes to export; compress a character with its meshes"
            )
        return self.model.meshes

    @property
    def difference_scale(self) -> NDArray[np.float32]:
        """``(R, C)``: D = (t - 128/255) · scale."""
        return self.maps.difference_scale

    @property
    def neutral_texels(self) -> Texels:
        """``(H, W, C)``, the neutral as stored, what lies outside the chart replaced by what is nearest inside."""
        neutral: Texels = Fill(self.covered)(self.maps.neutral)  # type: ignore[type-var, assignment]
        return neutral

    @property
    def difference_texels(self) -> NDArray[np.uint8]:
        """``(R, H, W, C)``, in the manifest's range, outside the chart as :attr:`neutral_texels`."""
        fill = Fill(self.covered)
        return np.stack([fill(one) for one in self.maps.differences])


def read_source(pack: Path) -> Source:
    """Verify a pack and read it for export.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` raises; ``BAD_VALUE`` for textures that are neither grey nor colour.
    """
    manifest = verify_pack(pack)
    if manifest.channels not in (1, 3):
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{pack}: textures of {manifest.channels} channels; engines take those of 1 or 3"
        )
    maps, meshes = read_stored(Path(pack), manifest)
    covered = np.ones(manifest.size, np.bool_)
    if meshes is not None:
        chart = rasterise(meshes.topology, manifest.size).covered
        covered = chart if chart.any() else covered
    model = dequantise(maps, manifest.expressions, manifest.method, meshes)
    return Source(Path(pack), manifest, maps, model, covered)


class Fill:
    """Makes each texel outside the chart like its nearest neighbour inside, so that no filter brings background in.

    Parameters
    ----------
    covered : ``(H, W)``, whether a texel is inside.
    """

    def __init__(self, covered: NDArray[np.bool_]) -> None:
        self._nearest: tuple[NDArray[np.int32], ...] | None = None
        if not covered.all():
            self._nearest = tuple(distance_transform_edt(~covered, return_distances=False, return_indices=True))

    def __call__(self, texels: NDArray[Kind]) -> NDArray[Kind]:
        """Fill ``(H, W, C)`` texels; those inside stay as they are."""
        return texels if self._nearest is None else texels[self._nearest]


def to_steps(differences: NDArray[np.float32], scale: NDArray[np.float32]) -> NDArray[np.uint8]:
    """``(R, H, W, C)`` differences as bytes of their ranges ``(R, C)``; what lies beyond is clipped."""
    per_unit = np.float32(255) / np.maximum(scale, np.float32(1e-30))[:, None, None]
    return np.clip(np.rint(differences * per_unit) + ZERO, 0, 255).astype(np.uint8)


def from_steps(texels: NDArray[np.uint8], scale: NDArray[np.float32]) -> NDArray[np.float32]:
    """Inverse of :func:`to_steps`, of ``(..., C)`` texels with ranges that broadcast to them."""
    values: NDArray[np.float32] = (texels.astype(np.float32) - np.float32(ZERO)) * (scale / np.float32(255))
    return values
