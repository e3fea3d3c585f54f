"""``facezip importance``: which texels the cameras look at, as a weight of the fit, and what that gains."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from facezip.character.loading import load_character
from facezip.commands import options
from facezip.commands.words import call
from facezip.files.images import write_values
from facezip.files.writing import whole_folder
from facezip.fit.importance import importance_files
from scenes.cameras import VIEWS
from scenes.lights import RIGS

if TYPE_CHECKING:
    from reports.importance.documents import ImportanceDocument

REPORT_FILE = "importance.json"


@click.command("importance")
@click.argument("character", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder to write.")
@click.option(
    "--views", type=click.IntRange(1, len(VIEWS)), default=2, show_default=True, metavar="N",
    help="How many camera views to use; the others are held out.",
)  # fmt: skip
@click.option(
    "--lights", type=click.IntRange(1, len(RIGS)), default=2, show_default=True, metavar="N",
    help="How many light rigs to use.",
)  # fmt: skip
@click.option("--material", type=click.Choice(["skin", "diffuse"]), default="skin", show_default=True)
@click.option(
    "--resolution", type=click.IntRange(16, 8192), default=512, show_default=True, metavar="PIXELS",
    help="Side of the images.",
)  # fmt: skip
@click.option(
    "--spp", type=click.IntRange(1, 4096), default=16, show_default=True, metavar="N", help="Samples per pixel."
)
@click.option(
    "--floor", type=options.FiniteRange(0, 1), default=0.3, show_default=True, metavar="X",
    help="What a texel that no view sees counts, in parts of the mean.",
)  # fmt: skip
@click.option(
    "--differences",
    default=4,
    show_default=True,
    metavar="R",
    help="Difference textures of the fits that show the effect.",
)
@click.option(
    "--weight-scale", default=8, show_default=True, metavar="S", help="Weight scale of the fits that show the effect."
)
@click.option("--seed", type=click.IntRange(0, 2**30), default=0, show_default=True, metavar="S")
@options.overwrite
@options.as_json
def command(
    character: Path,
    output: Path,
    views: int,
    lights: int,
    material: str,
    resolution: int,
    spp: int,
    floor: float,
    differences: int,
    weight_scale: int,
    seed: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Measure how much each texel of CHARACTER shows in renders of some views: DIR/importance.exr.

    `facezip compress --importance DIR/importance.exr` then fits with it. Several maps or tiles have an image each, such
    as DIR/importance.normal.1002.exr; give them with `--importance DIR`. DIR/index.html shows the images on the head,
    and compares a uniform fit with one that uses them, at equal bytes, in its own views and in held-out ones.

    For the albedo the weight is exact, since direct light is linear in it. For normals, roughness, specular and cavity
    it comes from finite differences, which are exact for small errors. It also sets how much maps count beside each
    other. Maps that light does not meet take the albedo's.
    """
    from render.importance import Sight
    from reports.importance.documents import FitSettings
    from reports.importance.experiment import looks_of, measure_importance
    from reports.importance.report import write_importance_report

    with whole_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        scans = load_character(character)
        made_for, held_out = looks_of(views, lights)
        sight = Sight(made_for, resolution, spp, seed, material)
        fit = FitSettings(differences=differences, weight_scale=weight_scale)
        document, importance = measure_importance(scans, sight, held_out, fit, floor)
        looks = f"--views {views} --lights {lights} --material {material} --resolution {resolution} --spp {spp} "
        looks += f"--floor {floor:g} --differences {differences} --weight-scale {weight_scale} --seed {seed}"
        command = call("importance", character, "-o", output, *looks.split())
        names = importance_files(scans)
        for key, values in importance.items():
            write_values(folder / names[key], values)
        document = replace(document, command=command)
        write_importance_report(document, scans, importance, sight, folder)
    taken = output if len(importance) > 1 else output / names[next(iter(importance))]
    answer = replace(document, output=str(output), importance_file=str(taken), report=str(output / "index.html"))
    options.answer(answer, as_json, lambda: _lines(answer))


def _lines(answer: "ImportanceDocument") -> list[str]:
    change, facts = answer.change, answer.importance
    lines = [
        f"{answer.importance_file}: {facts.seen_share:.0%} of the face region seen, floor {facts.floor:g}, "
        f"{answer.seconds.total:.0f} s"
    ]
    for pair, worst, words in (
        (change.made_for, change.worst_made_for, "its own views"),
        (change.held_out, change.worst_held_out, "held-out views"),
    ):
        if pair:
            lines.append(
                f"  image RMSE, {words}: {pair.importance:.3f} instead of {pair.uniform:.3f} of 255 "
                f"({pair.change:+.1%}), worst look {worst:+.1%}"
            )
    return [*lines, f"  open {answer.report}"]
