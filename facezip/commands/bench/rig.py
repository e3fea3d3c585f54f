"""``facezip bench rig``: generated shapes against the known truth."""

from typing import TYPE_CHECKING

import click

from facezip.commands import options
from facezip.machine.conditions import conditions

if TYPE_CHECKING:
    from reports.paper.documents.rig import MethodErrors, RigBenchDocument

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
    from reports.paper.documents.rig import RigBenchConditions, RigBenchDocument
    from reports.paper.generated import bench_rig

    found = bench_rig(resolution, seed, template_seed, seeds)
    about = RigBenchConditions(
        **vars(conditions(LIBRARIES)),
        character="embedded",
        resolution=(resolution, resolution),
        seed=seed,
        seeds=seeds,
        template=f"the same shapes on another identity, seed {template_seed}",
        neutral="the scanned neutral's own texture in the place of every shape's",
        cleaned="the neutral made of all scans in the place of every shape's",
    )
    document = RigBenchDocument(**vars(found), conditions=about)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: "RigBenchDocument") -> list[str]:
    clean, geometry, spread = document.clean, document.geometry, document.intervals
    condition = "infinite" if document.condition is None else f"{document.condition:.1f}"
    return [
        f"RMSE of {document.shapes:g} generated shapes to the truth, of 255: with nuisances, and clean",
        *(
            f"  {name:<10} {_number(document, spread, name)} {_number(clean, spread and spread.clean, name)}"
            for name in ("naive", "paper", "ours", "neutral", "cleaned")
        ),
        f"  ours is worse than the neutral for {document.worse_than_neutral:g} shapes (clean: "
        f"{clean.worse_than_neutral:g}), at most {document.worst_ratio:.2f} times ({clean.worst_ratio:.2f})",
        f"  geometry   {geometry.ours:.3f} of the mean displacement; template alone {geometry.transferred:.3f}",
        f"  cond(B)    {condition}, damping {document.damping:g}, clean {clean.damping:g}",
        f"  rigged in  {document.seconds['rig']:.1f} s",
    ]


def _number(found: "MethodErrors", spread: "MethodErrors | None", name: str) -> str:
    return f"{getattr(found, name):6.2f}" + (f" ± {getattr(spread, name):.2f}" if spread else "")
