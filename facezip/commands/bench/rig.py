"""``facezip bench rig``: generated shapes against the known truth."""

from collections.abc import Mapping
from typing import Any

import click

from facezip.commands import options
from facezip.machine.conditions import conditions

LIBRARIES = ("facezip", "numpy", "numba", "OpenImageIO", "scipy")


@click.command("rig")
@options.resolution
@options.seed
@click.option("--template-seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, metavar="S")
@click.option(
    "--seeds",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Persons, each with a template.",
)
@options.as_json
def command(resolution: int, seed: int, template_seed: int, seeds: int, as_json: bool) -> None:
    """Rig the embedded head, whose 52 shapes are known, from 20 scans and another person's template.

    Reports the RMSE of 255 (inside the mask) of the shapes' textures to the truth: for the naive weighted sum, the
    paper's method and ours, with the nuisances of a capture and without. Ours cleans the scans first, as --clean all
    does. With several seeds: means over persons, with 95 % intervals.
    """
    from reports.paper.generated import bench_rig

    document = bench_rig(resolution, seed, template_seed, seeds)
    document["conditions"] = {
        **conditions(LIBRARIES),
        "character": "embedded",
        "resolution": [resolution, resolution],
        "seed": seed,
        "seeds": seeds,
        "template": f"the same shapes on another identity, seed {template_seed}",
        "neutral": "the scanned neutral's own texture in the place of every shape's",
        "cleaned": "the neutral made of all scans in the place of every shape's",
    }
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Mapping[str, Any]) -> list[str]:
    clean, geometry, seconds = document["clean"], document["geometry"], document["seconds"]
    names = ("naive", "paper", "ours", "neutral", "cleaned")
    spread = document.get("intervals", {})
    return [
        f"RMSE of {document['shapes']} generated shapes to the truth, of 255: with nuisances, and clean",
        *(
            f"  {name:<10} {_number(document, spread, name)} {_number(clean, spread.get('clean', {}), name)}"
            for name in names
        ),
        f"  ours is worse than the neutral for {document['worse_than_neutral']:g} shapes (clean: "
        f"{clean['worse_than_neutral']:g}), at most {document['worst_ratio']:.2f} times ({clean['worst_ratio']:.2f})",
        f"  geometry   {geometry['ours']:.3f} of the mean displacement; template alone {geometry['transferred']:.3f}",
        f"  cond(B)    {document['condition']:.1f}, damping {document['damping']:g}, clean {clean['damping']:g}",
        f"  rigged in  {seconds['rig']:.1f} s",
    ]


def _number(found: Mapping[str, Any], spread: Mapping[str, Any], name: str) -> str:
    return f"{found[name]:6.2f}" + (f" ± {spread[name]:.2f}" if spread else "")
