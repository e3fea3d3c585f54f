"""``facezip bench metrics``: how true few samples are."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import click

from facezip.commands import options
from facezip.commands.bench.poses import BenchConditions, make_poses, shot_options, stated
from facezip.documents.document import Document
from render.documents.bench import MetricsBench


@dataclass(frozen=True, kw_only=True)
class MetricsBenchConditions(BenchConditions):
    """Samples of a converged render, and how deviations are stated, in words."""

    converged: int
    debiased: str
    deviation: str


@dataclass(frozen=True, kw_only=True)
class MetricsBenchDocument(MetricsBench, Document):
    """How true the metrics of few samples are.

    Attributes
    ----------
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-metrics/1"] = "facezip-bench-metrics/1"
    conditions: MetricsBenchConditions


@click.command("metrics")
@shot_options
@click.option("--converged", type=click.IntRange(64, 2**16), default=1024, show_default=True, metavar="N")
def command(character: Path | None, packs: int, expressions: int, converged: int, as_json: bool, **given: Any) -> None:
    """Compare the metrics of few samples with those of a converged render, in value and time."""
    from render.convergence import BATCH, HALF, bench_metrics
    from render.settings import read_settings

    if (converged // BATCH) & (converged // BATCH - 1) or converged % BATCH:
        raise click.BadParameter(f"{converged} is not {BATCH} times a power of two", param_hint="--converged")
    settings = read_settings(None, given)
    scans, poses = make_poses(character, packs, expressions, given["seed"])
    found = bench_metrics(scans, poses, settings, converged)
    about = MetricsBenchConditions(
        **vars(stated(scans, poses, settings)),
        converged=converged,
        debiased=f"two halves of {HALF} samples",
        deviation="relative to the converged metric; of SSIM the difference; over all renders and packs",
    )
    document = MetricsBenchDocument(**vars(found), conditions=about)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: MetricsBenchDocument) -> list[str]:
    about = document.conditions
    lines = [f"{about.spp} samples a pixel against {about.converged}: mean deviation, and the largest of a render"]
    for name, found in document.deviation.items():
        as_text = "{:+9.5f} {:9.5f}" if name == "ssim" else "{:+9.2%} {:9.2%}"
        lines.append(f"  {name:20}" + as_text.format(found.mean, found.largest))
    seconds = f"rendering {document.render_s:.2f} s, all metrics {document.metrics_s:.2f} s a shot"
    return [*lines, f"  ({about.debiased} for the debiased RMSE)", f"  {seconds}"]
