"""A pack, or other textures, as validation judges them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from facezip.pack.errors import MapErrors
from facezip.pack.facts import PackFacts
from render.documents.images import ErrorPlace, Look
from render.limits import Level


@dataclass(frozen=True, kw_only=True)
class RegionWorst(Look):
    """A number, and the render that it is of.

    Attributes
    ----------
    value : the number.
    """

    value: float


@dataclass(frozen=True, kw_only=True)
class Worst(RegionWorst):
    """The worst of a metric.

    Attributes
    ----------
    region : of the face, on which that render differs most; absent where it differs nowhere.
    """

    region: str | None = None


@dataclass(frozen=True, kw_only=True)
class WorstPlace(ErrorPlace, Look):
    """Where the render that the verdict names differs most.

    Attributes
    ----------
    exr, spp : its image, and samples a pixel.
    """

    exr: str
    spp: int


@dataclass(frozen=True, kw_only=True)
class TextureFacts:
    """Textures of another character in the place of a pack.

    Attributes
    ----------
    method : ``textures``.
    bytes_on_gpu, bytes_raw : at 8 bits a channel.
    bytes_bc7, bytes_raw_bc7 : in BC7 blocks.
    bytes_on_disk, fetches : null.
    """

    method: Literal["textures"] = "textures"
    bytes_on_gpu: int
    bytes_on_disk: None
    bytes_raw: int
    fetches: None
    bytes_bc7: int
    bytes_raw_bc7: int


@dataclass(frozen=True, kw_only=True)
class JudgedTextures:
    """What renders and textures say of a pack, over all renders.

    Attributes
    ----------
    name : of the pack or character.
    texture_rmse, texture_rmse_per_expression : of the albedo, 0..255, inside the mask.
    map_errors : by map.
    level : of its worst render.
    verdict : the same in one sentence.
    decided : whether that of every render is.
    levels : how many renders have which.
    image_rmse, flip, delta_e_mean, delta_e_p95, delta_e_local, ssim, image_rmse_debiased : means.
    psnr : of the mean RMSE.
    noise_floor : mean of the image RMSE's.
    noise_floor_per_metric : means by metric.
    worst : by metric.
    regions : the worst 95th percentile of CIEDE2000 of every region, worst first.
    worst_place : null without a difference.
    """

    name: str
    texture_rmse: float
    texture_rmse_per_expression: Mapping[str, float]
    map_errors: Mapping[str, MapErrors]
    level: Level
    verdict: str
    decided: bool
    levels: Mapping[str, int]
    image_rmse: float
    flip: float
    delta_e_mean: float
    delta_e_p95: float
    delta_e_local: float
    ssim: float
    image_rmse_debiased: float
    psnr: float | None
    noise_floor: float
    noise_floor_per_metric: Mapping[str, float]
    worst: Mapping[str, Worst]
    regions: Mapping[str, RegionWorst]
    worst_place: WorstPlace | None


@dataclass(frozen=True, kw_only=True)
class JudgedPack(JudgedTextures, PackFacts):
    """A pack of a validation."""


@dataclass(frozen=True, kw_only=True)
class JudgedCharacter(JudgedTextures, TextureFacts):
    """A character in the place of a pack."""


Judged = JudgedPack | JudgedCharacter
