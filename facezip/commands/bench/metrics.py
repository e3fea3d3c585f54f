"""``facezip bench metrics``: how true few samples are."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.bench.poses import make_poses, shot_options, stated


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
    document = bench_metrics(scans, poses, settings, converged)
    document["conditions"] = {
        **stated(scans, poses, settings),
        "converged": converged,
        "debiased": f"two halves of {HALF} samples",
        "deviation": "relative to the converged metric; of SSIM the difference; over all renders and packs",
    }
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Mapping[str, Any]) -> list[str]:
    about = document["conditions"]
    lines = [
        f"{about['spp']} samples a pixel against {about['converged']}: mean deviation, and the largest of a render"
    ]
    for name, found in document["deviation"].items():
        as_text = "{:+9.5f} {:9.5f}" if name == "ssim" else "{:+9.2%} {:9.2%}"
        lines.append(f"  {name:20}" + as_text.format(found["mean"], found["largest"]))
    seconds = f"rendering {document['render_s']:.2f} s, all metrics {document['metrics_s']:.2f} s a shot"
    return [*lines, f"  ({about['debiased']} for the debiased RMSE)", f"  {seconds}"]
