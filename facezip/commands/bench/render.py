"""``facezip bench render``: what shared light paths save."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import click

from facezip.commands import options
from facezip.commands.bench.poses import BenchConditions, make_poses, shot_options, stated
from facezip.documents.document import Document
from render.documents.bench import RenderBench


@dataclass(frozen=True, kw_only=True)
class RenderBenchConditions(BenchConditions):
    """What each way is, and which run is stated, in words."""

    naive: str
    paired: str
    statistic: str


@dataclass(frozen=True, kw_only=True)
class RenderBenchDocument(RenderBench, Document):
    """What shared light paths save.

    Attributes
    ----------
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-render/1"] = "facezip-bench-render/1"
    conditions: RenderBenchConditions


@click.command("render")
@shot_options
@options.repeats
def command(character: Path | None, packs: int, expressions: int, repeats: int, as_json: bool, **given: Any) -> None:
    """Time the paired renderer against one render for each image.

    Both render the same expressions, views and lights with the original's and every pack's texture, in turn. Kernels
    are compiled before. Packs are PCA with 1, 2, … differences; what they show does not change the time.
    """
    from render.bench import bench_render
    from render.settings import read_settings

    settings = read_settings(None, given)
    scans, poses = make_poses(character, packs, expressions, given["seed"])
    found = bench_render(scans, poses, settings, repeats)
    about = RenderBenchConditions(
        **vars(stated(scans, poses, settings)),
        naive="one Mitsuba scene and one mi.render per image, same sampler, samples, lights and skin",
        paired="one scene, mesh moved, all textures on the same paths; pose, upload and read-back included",
        statistic=f"the repeat of median speedup of {repeats}",
    )
    document = RenderBenchDocument(**vars(found), conditions=about)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: RenderBenchDocument) -> list[str]:
    about = document.conditions
    return [
        f"{document.images} images of {about.resolution}² at {about.spp} samples a pixel, "
        f"original and {about.packs} packs",
        f"  a scene each   {document.naive_s:8.2f} s",
        f"  shared paths   {document.paired_s:8.2f} s",
        f"  speedup        {document.speedup:8.2f}    ({about.statistic})",
        f"  pairs a second {document.pairs_per_second:8.2f}",
    ]
