"""``facezip bench rig``: generated shapes against the known truth."""

from collections.abc import Mapping
from typing import Any

import click

from facezip.commands import options
from facezip.machine.conditions import conditions

LIBRARIES = ("facezip", "numpy", "numba", "OpenImageIO", "scipy")


@click.command("rig")
@click.option("--resolution", type=click.IntRange(64, 4096), default=512, show_default=True, metavar="TEXELS")
@options.seed
@click.option("--template-seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, metavar="S")
@options.as_json
def command(resolution: int, seed: int, template_seed: int, as_json: bool) -> None:
    """Rig the embedded character, whose 52 shapes are known, from 20 scans and another person's template.

    RMSE (0..255, inside the mask) of the shapes' textures to the truth, of the naive weighted sum of differences, of
    the paper's method and of ours, as packs store them; with the nuisances of a capture, and clean without them.
    """
    from reports.paper.generated import bench_rig

    document = bench_rig(resolution, seed, template_seed)
    document["conditions"] = {
        **conditions(LIBRARIES),
        "character": "embedded",
        "resolution": [resolution, resolution],
        "seed": seed,
        "template": f"the same shapes on another identity, seed {template_seed}",
        "neutral": "the scanned neutral's own texture in the place of every shape's",
    }
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Mapping[str, Any]) -> list[str]:
    clean, geometry, seconds = document["clean"], document["geometry"], document["seconds"]
    names = ("naive", "paper", "ours", "neutral")
    return [
        f"RMSE of {document['shapes']} generated shapes to the truth, of 255: with nuisances, and clean",
        *(f"  {name:<10} {document[name]:6.2f} {clean[name]:6.2f}" for name in names),
        f"  geometry   {geometry['ours']:.3f} of the mean displacement; template alone {geometry['transferred']:.3f}",
        f"  cond(B)    {document['condition']:.1f}, damping {document['damping']:g}, clean {clean['damping']:g}",
        f"  rigged in  {seconds['rig']:.1f} s",
    ]
