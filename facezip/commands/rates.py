"""``facezip rates``: error against GPU memory, packs beside block compression of every texture."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from facezip.blocks.codecs import EFFORTS
from facezip.character.loading import load_character
from facezip.commands import options
from facezip.commands.words import call
from facezip.documents.document import plain
from facezip.files.writing import whole_folder
from facezip.pack.facts import several

if TYPE_CHECKING:
    from reports.rates.documents import RatesDocument

REPORT_FILE = "rates.json"


@click.command("rates")
@click.argument("character", type=options.FOLDER, required=False)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option(
    "--blends-to",
    type=click.IntRange(min=0),
    default=52,
    show_default=True,
    metavar="N",
    help="Repeat with N expressions, filled up with blends of the others; 0 to skip.",
)
@click.option(
    "--effort",
    type=click.Choice(list(EFFORTS)),
    default="medium",
    show_default=True,
    help="How long the ASTC encoder tries.",
)
@click.option("--resolution", default=512, show_default=True, metavar="TEXELS", help="Size of the embedded head.")
@click.option("--expressions", default=20, show_default=True, metavar="N", help="Expressions of the embedded head.")
@options.seed
@options.overwrite
@options.as_json
def command(
    character: Path | None,
    output: Path,
    blends_to: int,
    effort: str,
    resolution: int,
    expressions: int,
    seed: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Measure error against GPU memory, on CHARACTER or on the embedded head: DIR/index.html.

    Compares packs of all sizes (refined, paper, PCA; raw, BC7, ASTC) with BC1, BC7 and ASTC on every texture. The
    refined fit has the codec in its loop: each texture makes up for what coding lost of the others. DIR/rates.json
    holds every number.

    All maps and tiles of CHARACTER count. The embedded head has its albedo here.
    """
    from reports.rates.experiment import measure_rates
    from reports.rates.report import write_rates_report
    from scenes.character import make_character

    options.check_embedded(character, "resolution", "expressions")
    with whole_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        scans = load_character(character) if character else make_character(resolution, expressions, seed)
        document = measure_rates(scans, blends_to, effort, seed)
        made = [character] if character else ["--resolution", resolution, "--expressions", expressions]
        command = call("rates", *made, "-o", output, "--blends-to", blends_to, "--effort", effort, "--seed", seed)
        document = replace(document, command=command)
        write_rates_report(document, folder)
    answer = replace(document, output=str(output), report=str(output / "index.html"))
    options.answer(answer, as_json, lambda: _lines(answer))


def _lines(answer: "RatesDocument") -> list[str]:
    from reports.rates.findings import find

    return [
        f"{answer.output}: {answer.character.name}{several(answer.character)}, {answer.seconds.total:.0f} s",
        *(f"  {finding.title}: {finding.here}" for finding in find(plain(answer))),
        f"  open {answer.report}",
    ]
