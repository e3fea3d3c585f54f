"""``facezip bench render`` and ``bench metrics``: what shared light paths save, and how true few samples are."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from facezip.character import Character, load_character
from facezip.commands import options
from facezip.machine import conditions
from facezip.methods import compress

if TYPE_CHECKING:
    from render.bench import Pose
    from render.settings import Settings

LIBRARIES = ("facezip", "mitsuba", "drjit", "numpy", "numba")
TEXELS = 512


def _shared(command: Callable[..., None]) -> Callable[..., None]:
    """The options that both have, in the order of ``--help``."""
    count = click.IntRange(min=1)
    for option in reversed(
        (
            click.option("--character", type=options.FOLDER, metavar="FOLDER", help="Scans; the embedded one if none."),
            click.option("--packs", type=click.IntRange(1, 15), default=2, show_default=True, metavar="N"),
            click.option("--expressions", type=count, default=2, show_default=True, metavar="N"),
            click.option("--views", type=count, default=1, show_default=True, metavar="N"),
            click.option("--lights", type=count, default=2, show_default=True, metavar="N"),
            click.option("--material", type=click.Choice(["skin", "diffuse"]), default="skin", show_default=True),
            click.option("--transport", type=click.Choice(["direct", "full"]), default="direct", show_default=True),
            click.option("--resolution", type=int, default=512, show_default=True, metavar="PIXELS"),
            click.option("--spp", type=int, default=16, show_default=True, metavar="N"),
            click.option("--seed", type=int, default=0, show_default=True, metavar="S"),
        )
    ):
        command = option(command)
    return options.as_json(command)


@click.command("render")
@_shared
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, metavar="N")
def render(character: Path | None, packs: int, expressions: int, repeats: int, as_json: bool, **given: Any) -> None:
    """Time shared light paths against a scene and a call of mi.render for each image.

    Both ways render the same expressions, views and lights with the original's and every pack's texture, in turn,
    with kernels compiled before. Packs are PCA with 1, 2, … differences: what they show does not change the time.
    """
    from render.bench import bench_render
    from render.settings import read_settings

    settings = read_settings(None, given)
    scans, poses = _poses(character, packs, expressions, given["seed"])
    document = bench_render(scans, poses, settings, repeats)
    document["conditions"] = {
        **_conditions(scans, poses, settings),
        "naive": "one Mitsuba scene and one mi.render per image, same sampler, samples, lights and skin",
        "paired": "one scene, mesh moved, all textures on the same paths; pose, upload and read-back included",
        "statistic": f"the repeat of median speedup of {repeats}",
    }
    options.answer(document, as_json, lambda: _render_lines(document))


@click.command("metrics")
@_shared
@click.option("--converged", type=click.IntRange(64, 2**16), default=1024, show_default=True, metavar="N")
def metrics(character: Path | None, packs: int, expressions: int, converged: int, as_json: bool, **given: Any) -> None:
    """Compare the metrics of few samples with those of a converged render, and their time with the rendering's."""
    from render.convergence import BATCH, HALF, bench_metrics
    from render.settings import read_settings

    if (converged // BATCH) & (converged // BATCH - 1) or converged % BATCH:
        raise click.BadParameter(f"{converged} is not {BATCH} times a power of two", param_hint="--converged")
    settings = read_settings(None, given)
    scans, poses = _poses(character, packs, expressions, given["seed"])
    document = bench_metrics(scans, poses, settings, converged)
    document["conditions"] = {
        **_conditions(scans, poses, settings),
        "converged": converged,
        "debiased": f"two halves of {HALF} samples",
        "deviation": "relative to the converged metric; of SSIM the difference; over all renders and packs",
    }
    options.answer(document, as_json, lambda: _metric_lines(document))


def _poses(character: Path | None, packs: int, expressions: int, seed: int) -> "tuple[Character, list[Pose]]":
    from render.bench import Pose
    from scenes.character import make_character

    scans = load_character(character) if character else make_character(TEXELS, max(expressions, packs + 2), seed)
    model = compress(scans, method="pca", differences=packs)
    models = [
        replace(model, differences=model.differences[:count], weights=model.weights[..., :count])
        for count in range(1, packs + 1)
    ]
    return scans, [
        Pose(scans.mesh_vertices(name), [scans.texture(name), *(one.reconstruct(name) for one in models)])
        for name in scans.expressions[:expressions]
    ]


def _conditions(scans: Character, poses: "list[Pose]", settings: "Settings") -> dict[str, Any]:
    return {
        **conditions(LIBRARIES),
        **settings.resolved,
        "character": scans.name,
        "texels": list(scans.resolution),
        "expressions": len(poses),
        "packs": len(poses[0].textures) - 1,
    }


def _render_lines(document: Mapping[str, Any]) -> list[str]:
    about = document["conditions"]
    return [
        f"{document['images']} images of {about['resolution']}² at {about['spp']} samples a pixel, "
        f"original and {about['packs']} packs",
        f"  a scene each   {document['naive_s']:8.2f} s",
        f"  shared paths   {document['paired_s']:8.2f} s",
        f"  speedup        {document['speedup']:8.2f}    ({about['statistic']})",
        f"  pairs a second {document['pairs_per_second']:8.2f}",
    ]


def _metric_lines(document: Mapping[str, Any]) -> list[str]:
    about = document["conditions"]
    lines = [
        f"{about['spp']} samples a pixel against {about['converged']}: mean deviation, and the largest of a render"
    ]
    for name, found in document["deviation"].items():
        as_text = "{:+9.5f} {:9.5f}" if name == "ssim" else "{:+9.2%} {:9.2%}"
        lines.append(f"  {name:20}" + as_text.format(found["mean"], found["largest"]))
    seconds = f"rendering {document['render_s']:.2f} s, all metrics {document['metrics_s']:.2f} s a shot"
    return [*lines, f"  ({about['debiased']} for the debiased RMSE)", f"  {seconds}"]
