"""``facezip validate``: path-traced proof, a character against packs of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from facezip.character import Character, load_character
from facezip.commands import options
from facezip.commands.candidates import candidate
from facezip.writing import whole_folder

if TYPE_CHECKING:
    from render.validation import Candidate

REPORT_FILE = "report.json"


@click.command("validate")
@click.argument("character", type=options.FOLDER)
@click.argument("packs", type=options.FOLDER, nargs=-1, required=True, metavar="PACK...")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option("--views", default=2, show_default=True, metavar="N", help="How many of the camera views.")
@click.option("--lights", default=2, show_default=True, metavar="N", help="How many of the light rigs.")
@click.option("--material", type=click.Choice(["skin", "diffuse"]), default="skin", show_default=True)
@click.option("--resolution", default=512, show_default=True, metavar="PIXELS", help="Side of the rendered images.")
@click.option("--spp", default=16, show_default=True, metavar="N", help="Samples per pixel.")
@click.option("--seed", default=0, show_default=True, metavar="S")
@options.overwrite
@options.as_json
def command(
    character: Path, packs: tuple[Path, ...], output: Path, overwrite: bool, as_json: bool, **settings: Any
) -> None:
    """Render every expression of CHARACTER with its original and its compressed textures, and report the difference.

    Both sides are shaded on the same light paths, so that the difference is the compression's alone. In the place of
    a PACK stands, if you like, a second CHARACTER: textures that another tool made are judged the same way.
    """
    scans = load_character(character)
    candidates = [candidate(scans, path) for path in packs]
    document = _validate_into(scans, candidates, output, overwrite, settings)
    options.answer(document, as_json, lambda: _lines(document, output))


def _validate_into(
    scans: Character,
    candidates: "list[Candidate]",
    output: Path,
    overwrite: bool,
    settings: dict[str, Any],
) -> dict[str, Any]:
    """Render, measure and report into the folder ``output``; returns the report's document."""
    from render.validation import Settings, validate
    from reports.validation import write_validation_report

    with whole_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        document = validate(scans, candidates, folder, Settings(**settings))
        write_validation_report(document, folder)
    return document


def _lines(document: dict[str, Any], output: Path) -> list[str]:
    lines = []
    for pack in document["packs"]:
        worst = pack["worst"]["delta_e_p95"]
        lines += [
            f"{pack['name']}: {pack['verdict']}",
            f"  texture RMSE {pack['texture_rmse']:.2f}, image RMSE {pack['image_rmse']:.2f} of 255 "
            f"(noise floor {pack['noise_floor']:.2f}), dE2000 p95 {pack['delta_e_p95']:.2f}, FLIP {pack['flip']:.4f}, "
            f"SSIM {pack['ssim']:.4f}",
            f"  worst {worst['expression']}, view {worst['view']}, light {worst['light']}",
        ]
    return [*lines, f"{output / 'index.html'}"]
