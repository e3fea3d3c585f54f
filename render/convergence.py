"""How true the metrics of few samples are: their deviation from those of a converged render."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from facezip.character.scans import Character
from facezip.machine.progress import track
from render.bench import Pose, renderer_of
from render.decision import of_halves, stream, without_bias
from render.documents.bench import Deviation, MetricsBench
from render.documents.images import ImageMetrics
from render.metrics import METRICS, Picture, compare, display, head_crop
from render.noise import Halves, debiased_rmse
from render.paired import Images, PairedRenderer
from render.settings import Settings
from render.skins import Skin, SkinMaps, upload
from scenes.cameras import View

# Samples of the two halves that the debiased estimate is made of.
HALF = 4
# Samples of each render that a converged one is the mean of.
BATCH = 64


def bench_metrics(character: Character, poses: Sequence[Pose], settings: Settings, converged: int) -> MetricsBench:
    """Measure every pose, view and light with ``settings.spp`` samples and with ``converged`` ones."""
    renderer = renderer_of(character, settings)
    seconds = {"render": 0.0, "metrics": 0.0}
    rows = []
    looks = [(view, light) for view in settings.views for light in settings.lights]
    jobs = [(pose, *look) for pose in poses for look in looks]
    for pose, view, light in track(jobs, "Converging", len(jobs)):
        renderer.pose(pose.vertices)
        skins = [upload(SkinMaps(texture)) for texture in pose.textures]
        rows += _deviations(renderer, skins, view, light, settings, converged, seconds)
    metrics = {name: [row[name] for row in rows] for name in rows[0]}
    return MetricsBench(
        deviation={
            name: Deviation(mean=float(np.mean(values)), largest=float(np.abs(values).max()))
            for name, values in metrics.items()
        },
        render_s=seconds["render"] / len(jobs),
        metrics_s=seconds["metrics"] / len(jobs),
    )


def _deviations(
    renderer: PairedRenderer,
    skins: Sequence[Skin],
    view: View,
    light: str,
    settings: Settings,
    converged: int,
    seconds: dict[str, float],
) -> list[dict[str, float]]:
    def render(spp: int, *position: int) -> Images:
        return renderer.render(skins, view, light, spp, stream(settings.seed, *position))

    truth = _compared(_mean_of([render(BATCH, 2, batch) for batch in range(converged // BATCH)]))
    begin = perf_counter()
    few = Halves(*(render(settings.spp // 2, 0, half) for half in range(2)))
    mean = few.mean
    between = perf_counter()
    measured = _compared(mean)
    seconds["render"] += between - begin
    seconds["metrics"] += perf_counter() - between
    halves = Halves(*(render(HALF, 1, half) for half in range(2)))
    head = halves.mean.coverage >= 0.5
    rows = []
    for k, (found, true) in enumerate(zip(_judged(few, measured), truth, strict=True), 1):
        row = {name: getattr(found, name) / getattr(true, name) - 1 for name in METRICS if name != "ssim"}
        row["delta_e_p95_plain"] = measured[k - 1].delta_e_p95 / true.delta_e_p95 - 1
        debiased = debiased_rmse(halves, k, head) / true.image_rmse - 1
        rows.append({**row, "ssim": found.ssim - true.ssim, "image_rmse_debiased": debiased})
    return rows


def _mean_of(renders: Sequence[Images]) -> Images:
    """The image with the samples of all renders, each of as many."""
    while len(renders) > 1:
        renders = [Halves(*pair).mean for pair in zip(renders[::2], renders[1::2], strict=True)]
    return renders[0]


def _compared(image: Images) -> list[ImageMetrics]:
    original, *others = _pictures(image, image)
    return [compare(original, other) for other in others]


def _judged(few: Halves, measured: list[ImageMetrics]) -> list[ImageMetrics]:
    """What ``validate`` makes of metrics of the mean: the deciding ones without the bias of noise."""
    first, second = (_pictures(half, few.mean) for half in (few.first, few.second))
    each = [of_halves(((first[0], one), (second[0], other))) for one, other in zip(first[1:], second[1:], strict=True)]
    return [replace(found, **without_bias(found, halves)) for found, halves in zip(measured, each, strict=True)]


def _pictures(image: Images, shape: Images) -> list[Picture]:
    """The crops of an image around the head of another."""
    crop = head_crop(shape.coverage)
    head = shape.coverage[crop] >= 0.5
    return [Picture(display(linear[crop]), head) for linear in image.linear]
