"""``facezip rig``: scans and a template in, the person's own shapes and a pack that blends them out."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.fit_options import STREAMED, clean
from facezip.commands.words import cleaning_words, megabytes
from facezip.fit.settings import USED
from facezip.machine.memory import beside, limited
from facezip.pack.facts import several
from facezip.rigging.documents import RigDocument, RigRequest
from facezip.rigging.pipeline import rig_into
from facezip.rigging.rigged import MAPS


@click.command("rig")
@click.argument("character", type=options.FOLDER)
@click.option(
    "--template", type=options.FOLDER, required=True, metavar="TEMPLATE", help="Folder of shapes to generate."
)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the rig.")
@click.option(
    "--method",
    # Uniform weights have no place to put a wrinkle.
    type=click.Choice([name for name in USED if name != "pca"]),
    default="refined",
    show_default=True,
    help="How the textures are compressed.",
)
@click.option("--maps", type=click.Choice(MAPS), default=MAPS[0], show_default=True, help="Weight maps of the shapes.")
@clean
@options.seed
@options.memory
@options.overwrite
@options.as_json
def command(
    character: Path, template: Path, output: Path, memory: int | None, overwrite: bool, as_json: bool, **given: Any
) -> None:
    """Give the person of CHARACTER the shapes of TEMPLATE, with geometry and textures.

    TEMPLATE holds neutral.obj and NAME.obj for each shape, such as ARKit's 52, on any identity, in CHARACTER's
    topology. It needs no textures. DIR then holds shapes/; the pack NAME.facezip, whose expressions are the shapes,
    with all maps and tiles; rig.json, which says what every scan is made of and how well scans show each shape; and a
    picture of that, evidence.png. If the scans do not show a shape's texture, it keeps the neutral's.

    For scans straight from a capture, --clean all brings the textures nearer to the truth.
    """
    from reports.evidence import write_evidence

    request = RigRequest(**given)
    if memory is not None and request.method not in STREAMED:
        raise click.UsageError("--memory needs --method refined or masks: the paper's holds all textures")
    with limited(memory, beside(output)):
        answer = replace(rig_into(character, template, output, request, overwrite, write_evidence), output=str(output))
    options.answer(answer, as_json, lambda: _lines(answer))


def _lines(answer: RigDocument) -> list[str]:
    fit = answer.fit
    worst = max(fit, key=lambda name: fit[name].rms_left)
    left, size = fit[worst].rms_left, fit[worst].rms_displacement
    unseen = answer.unseen_shapes
    condition = "infinite" if answer.condition is None else f"{answer.condition:.3g}"
    pack = answer.pack
    gpu = f"{megabytes(pack.bytes_bc7)} on the GPU in BC7, {pack.fetches} fetches a pixel{several(pack)}"
    return [
        f"{answer.output}: {len(answer.shapes)} shapes from {len(fit)} scans, rigged in "
        f"{answer.seconds.rig:.1f} s of {answer.seconds.total:.1f} s",
        *(f"  cleaned  {line}" for line in cleaning_words(answer.cleaning)),
        f"  fit      worst scan {worst}: {left:.3g} left of {size:.3g} (RMS displacement, the mesh's unit)",
        f"  B        rank {answer.rank} of {len(fit)}, condition {condition}",
        f"  unseen   {len(unseen)} shapes hardly in any scan: nearly the template's motion and the neutral's texture"
        + (f": {', '.join(unseen)}" if unseen else ""),
        f"  shown    {_shown(answer)}",
        f"  pack     {pack.path}, {gpu}",
    ]


def _shown(answer: RigDocument) -> str:
    """How many shapes' textures scans determine, at least by half."""
    shares = [found.shown for found in answer.evidence.values() if found.shown is not None]
    if not shares:
        return "nothing is known of the textures of pseudo-inverse maps"
    half = sum(share >= 0.5 for share in shares)
    return f"scans determine the texture of {half} of {len(shares)} shapes by half or more (evidence.png)"
