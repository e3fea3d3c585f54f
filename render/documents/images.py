"""What was measured of one image, and which image it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from render.limits import Level


@dataclass(frozen=True, kw_only=True)
class ImageMetrics:
    """How different two renders look, over head pixels.

    Attributes
    ----------
    image_rmse : 0..255 of the encoded (sRGB) values.
    psnr : dB; null for equal images.
    flip : mean FLIP, 0..1.
    delta_e_mean, delta_e_p95 : mean and 95th percentile of CIEDE2000.
    delta_e_local : the largest mean of CIEDE2000 over a small window.
    ssim : mean SSIM of the luma, 1 for equal images.
    """

    image_rmse: float
    psnr: float | None
    flip: float
    delta_e_mean: float
    delta_e_p95: float
    delta_e_local: float
    ssim: float


@dataclass(frozen=True, kw_only=True)
class ErrorPlace:
    """Where on the face a render differs most.

    Attributes
    ----------
    region : of the face.
    delta_e_p95 : 95th percentile of CIEDE2000 in that region.
    box : first row and column, height and width of the square in which it is worst.
    """

    region: str
    delta_e_p95: float
    box: tuple[int, int, int, int]


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """The metrics that decide, free of the bias of noise.

    Attributes
    ----------
    delta_e_p95, delta_e_local, flip : as of :class:`ImageMetrics`.
    level : what they amount to.
    decided : whether both ends of the intervals have the same level.
    interval : of each, where it lies with 95 % confidence.
    """

    delta_e_p95: float
    delta_e_local: float
    flip: float
    level: Level
    decided: bool
    interval: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class PackRender(Judgement, ImageMetrics):
    """One render of one pack against the original.

    Attributes
    ----------
    image_rmse_debiased : image RMSE from two independent halves of the samples.
    regions : 95th percentile of CIEDE2000 by region of the face.
    where : the place of the largest error; null where there is none.
    """

    image_rmse_debiased: float
    regions: Mapping[str, float]
    where: ErrorPlace | None


@dataclass(frozen=True, kw_only=True)
class RmseFloor:
    """RMSE of the original against itself with other random numbers, 0..255."""

    image_rmse: float


@dataclass(frozen=True, kw_only=True)
class Look:
    """Which render: expression or ``neutral``, view and light by name."""

    expression: str
    view: str
    light: str


@dataclass(frozen=True, kw_only=True)
class Taken(Look):
    """One shot, as it is kept beside its image.

    Attributes
    ----------
    spp : samples a pixel that it took.
    noise_floor : of this shot.
    packs : in their order.
    exr : the image's file, relative to the report's folder.
    """

    spp: int
    noise_floor: RmseFloor
    packs: Sequence[PackRender]
    exr: str


@dataclass(frozen=True, kw_only=True)
class Render(Look):
    """One shot.

    Attributes
    ----------
    spp : samples a pixel that it took.
    noise_floor : what noise alone does to every metric in this view and light.
    packs : in their order.
    exr : the image's file, relative to the report's folder: a part ``original``, then one a pack.
    """

    spp: int
    noise_floor: ImageMetrics
    packs: Sequence[PackRender]
    exr: str
