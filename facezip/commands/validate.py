"""``facezip validate``: path-traced proof, a character against packs of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from facezip.commands import options
from facezip.commands.candidates import candidate
from facezip.commands.layered import error_words
from facezip.commands.staged import staged_candidate, staged_character, staged_original
from facezip.surface.folder import load_surface
from facezip.surface.scans import Surface
from facezip.writing import resumable_folder

if TYPE_CHECKING:
    from render.settings import Settings
    from render.validation import Candidate

REPORT_FILE = "report.json"


@click.command("validate")
@click.argument("character", type=options.FOLDER)
@click.argument("packs", type=options.FOLDER, nargs=-1, required=True, metavar="PACK...")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option("--config", type=options.FOLDER, metavar="FILE.toml", help="Views, lights, skin, samples, limits.")
@click.option("--views", type=int, metavar="N", help="How many of the camera views.  [default: 2]")
@click.option("--lights", type=int, metavar="N", help="How many of the light rigs.  [default: 2]")
@click.option("--material", type=click.Choice(["skin", "diffuse"]), help="What light meets.  [default: skin]")
@click.option("--transport", type=click.Choice(["direct", "full"]), help="How light travels.  [default: direct]")
@click.option("--resolution", type=int, metavar="PIXELS", help="Side of the rendered images.  [default: 512]")
@click.option("--spp", type=int, metavar="N", help="Samples per pixel to begin with.  [default: 16]")
@click.option("--max-spp", type=int, metavar="N", help="Samples where the verdict is close.  [default: 4 x spp]")
@click.option("--seed", type=int, metavar="S", help="Of all random numbers.  [default: 0]")
@options.overwrite
@options.as_json
def command(
    character: Path,
    packs: tuple[Path, ...],
    output: Path,
    config: Path | None,
    overwrite: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Render every expression of CHARACTER with its original and its compressed textures, and report the difference.

    Both sides are shaded on the same light paths, so that the difference is the compression's alone. In the place of
    a PACK stands, if you like, a second CHARACTER: textures that another tool made are judged the same way.

    Normal and roughness maps are rendered too, and UDIM tiles.

    A run that is broken off goes on where it was when it is started again. With --overwrite, renders of the report
    that is there are kept where nothing that made them has changed.
    """
    from render.settings import read_settings

    settings = read_settings(config, {key: value for key, value in given.items() if value is not None})
    surface = load_surface(character)
    if surface.ordinary:
        candidates = [candidate(surface.whole, path) for path in packs]
    else:
        candidates = [staged_candidate(surface, path) for path in packs]
    document = _validate_into(surface, candidates, output, overwrite, settings)
    options.answer(document, as_json, lambda: _lines(document, output))


def _validate_into(
    surface: Surface,
    candidates: "list[Candidate]",
    output: Path,
    overwrite: bool,
    settings: "Settings",
) -> dict[str, Any]:
    """Render, measure and report into the folder ``output``; returns the report's document."""
    from render.validation import validate
    from reports.validation import write_validation_report

    staged = not surface.ordinary
    scans = staged_character(surface) if staged else surface.whole
    original = staged_original(surface) if staged else None
    earlier = output if output.is_dir() else None
    with resumable_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        document = validate(scans, candidates, folder, settings, earlier, original)
        document["character"] = surface.facts if staged else scans.facts
        write_validation_report(document, folder)
    return document


def _lines(document: dict[str, Any], output: Path) -> list[str]:
    lines = []
    for pack in document["packs"]:
        lines += [
            f"{pack['name']}: {pack['verdict']}",
            f"  texture RMSE {pack['texture_rmse']:.2f}, image RMSE {pack['image_rmse']:.2f} of 255 "
            f"(noise floor {pack['noise_floor']:.2f}), dE2000 p95 {pack['delta_e_p95']:.2f}, FLIP {pack['flip']:.4f}, "
            f"SSIM {pack['ssim']:.4f}",
            *(f"  {name:<10} {error_words(found)}" for name, found in pack.get("map_errors", {}).items()),
        ]
    count, rendered, seconds = len(document["renders"]), document["rendered"], document["seconds"]
    taken = f", {count - rendered} taken over" if rendered < count else ""
    lines.append(f"{rendered} renders in {seconds['render']:.1f} s, measured in {seconds['metrics']:.1f} s{taken}")
    return [*lines, f"{output / 'index.html'}"]
