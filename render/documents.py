"""What ``facezip validate`` and ``facezip animate`` measured; ``reports`` shows it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.pack.errors import MapErrors
from facezip.pack.facts import PackFacts
from render.limits import Level, Thresholds
from scenes.cameras import View


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


@dataclass(frozen=True, kw_only=True)
class Versions:
    """Of the renderer: Mitsuba's variant, Mitsuba, Dr.Jit and LLVM."""

    variant: str
    mitsuba: str
    drjit: str
    llvm: str


@dataclass(frozen=True, kw_only=True)
class RenderConditions(Versions):
    """How renders were made.

    Attributes
    ----------
    views, lights : cameras, and rigs by name.
    material, transport : what light meets, and how it travels.
    resolution : width and height in pixels.
    spp : samples a pixel to begin with.
    seed : of all random numbers.
    units : of metrics, by name.
    """

    views: Sequence[View]
    lights: Sequence[str]
    material: str
    transport: str
    resolution: int
    spp: int
    seed: int
    units: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class ValidationConditions(RenderConditions):
    """How a validation was made.

    Attributes
    ----------
    max_spp : samples a pixel where the verdict is close.
    thresholds : the limits of the verdict.
    sampler, display, region, texture_region, confidence : in words.
    pixels_per_degree : of FLIP's display.
    debiased : metrics that are free of the bias of noise.
    """

    max_spp: int
    thresholds: Thresholds
    sampler: str
    pixels_per_degree: float
    display: str
    region: str
    texture_region: str
    confidence: str
    debiased: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class RenderSeconds:
    """Of rendering and measuring, over all processes, and of the whole job."""

    render: float
    metrics: float
    total: float


@dataclass(frozen=True, kw_only=True)
class Baseline:
    """Texture errors of another method.

    Attributes
    ----------
    name : of the method.
    texture_rmse, texture_rmse_per_expression : of the albedo, 0..255, inside the mask.
    bytes_on_gpu, fetches : what it costs.
    """

    name: str
    texture_rmse: float
    texture_rmse_per_expression: Mapping[str, float]
    bytes_on_gpu: int
    fetches: int


@dataclass(frozen=True, kw_only=True)
class ValidationDocument(Document):
    """A character rendered with its own and with each pack's textures, as it stands in ``report.json``.

    Attributes
    ----------
    character, conditions : what was rendered, and how.
    packs : in the order of the command line.
    renders : every expression in every view and light.
    rendered : how many of them were made now; others were taken over.
    seconds : spent.
    pairs_per_second : of original and pack.
    baselines : other methods, where a demo measured them.
    command : which makes the report again.
    """

    format: Literal["facezip-validation/3"] = "facezip-validation/3"
    character: CharacterFacts
    conditions: ValidationConditions
    packs: Sequence[Judged]
    renders: Sequence[Render]
    rendered: int
    seconds: RenderSeconds
    pairs_per_second: float
    baselines: Sequence[Baseline] | None = None
    command: str | None = None


@dataclass(frozen=True, kw_only=True)
class FrameErrors(ImageMetrics):
    """Errors of a frame, or their means over frames.

    Attributes
    ----------
    texture_rmse : of the albedo, 0..255, inside the mask.
    map_errors : by map.
    """

    texture_rmse: float
    map_errors: Mapping[str, MapErrors]


@dataclass(frozen=True, kw_only=True)
class FrameMeans:
    """Means over frames, as of :class:`FrameErrors`."""

    texture_rmse: float
    image_rmse: float
    flip: float
    delta_e_mean: float
    delta_e_p95: float
    ssim: float
    map_errors: Mapping[str, MapErrors]


@dataclass(frozen=True, kw_only=True)
class Frame(FrameErrors):
    """One frame.

    Attributes
    ----------
    frame : its number.
    pose : that it belongs to.
    weights : the blend, by expression.
    """

    frame: int
    pose: str
    weights: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class AnimationConditions(RenderConditions):
    """How an animation was made.

    Attributes
    ----------
    maps_rendered : those that light meets.
    """

    maps_rendered: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class TotalSeconds:
    """Of the whole job."""

    total: float


@dataclass(frozen=True, kw_only=True)
class AnimationDocument(Document):
    """A blend in motion, original against compressed, as it stands in ``animation.json``.

    Attributes
    ----------
    character, conditions : what was rendered, and how.
    original : what the pack is compared with.
    frames : all of them.
    means : over frames.
    worst : the number of the frame with the largest image RMSE.
    seconds : spent.
    pack : its name.
    command : which makes the report again.
    output : the report's folder; not in the file.
    """

    format: Literal["facezip-animation/1"] = "facezip-animation/1"
    character: CharacterFacts
    original: str
    conditions: AnimationConditions
    frames: Sequence[Frame]
    means: FrameMeans
    worst: int
    seconds: TotalSeconds
    pack: str | None = None
    command: str | None = None
    output: str | None = None


@dataclass(frozen=True, kw_only=True)
class BothWays:
    """One run of both ways.

    Attributes
    ----------
    naive_s, paired_s : seconds of each.
    speedup : of the paired way.
    pairs_per_second : of original and pack, the paired way.
    """

    naive_s: float
    paired_s: float
    speedup: float
    pairs_per_second: float


@dataclass(frozen=True, kw_only=True)
class RenderBench(BothWays):
    """The run of median speedup.

    Attributes
    ----------
    images : that each way renders.
    runs : all of them.
    """

    images: int
    runs: Sequence[BothWays]


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """Of a metric from the converged one, over all renders and packs: the mean, and the largest."""

    mean: float
    largest: float


@dataclass(frozen=True, kw_only=True)
class MetricsBench:
    """How true the metrics of few samples are.

    Attributes
    ----------
    deviation : by metric; relative for RMSE, FLIP and ΔE, absolute for SSIM. ``delta_e_p95_plain`` is the 95th
        percentile with the bias of noise.
    render_s, metrics_s : seconds a render with the fewer samples.
    """

    deviation: Mapping[str, Deviation]
    render_s: float
    metrics_s: float
