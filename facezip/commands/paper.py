"""``facezip paper``: the paper's Table 1 and Figures 6, 7 and 8, on any character, with our methods beside its own."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from facezip.character.loading import load_character
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import call
from facezip.files.writing import whole_folder

if TYPE_CHECKING:
    from reports.paper.documents.figures import ShapesFigure
    from reports.paper.documents.paper import PaperDocument
    from reports.paper.experiments import Settings

REPORT_FILE = "paper.json"
Shapes = Callable[[Character], "ShapesFigure"]
EMBEDDED = (512, 1024, 2048)
POSITIVE = click.IntRange(min=1)


@click.command("paper")
@click.argument("character", type=options.FOLDER, required=False)
@click.option("--template", type=options.FOLDER, metavar="FOLDER", help="Shapes to generate, for Figure 8.")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option(
    "--resolution",
    "resolutions",
    type=POSITIVE,
    multiple=True,
    metavar="TEXELS",
    help="Side of the textures. May be repeated; the figures use the first (with scans, the largest).",
)
@click.option("--expressions", default=20, show_default=True, metavar="N", help="Expressions of the embedded head.")
@click.option("--masks", type=POSITIVE, default=53, show_default=True, metavar="K", help="Masks on the face.")
@click.option(
    "--restarts", type=POSITIVE, default=100, show_default=True, metavar="N", help="Random starts of the stitching."
)
@click.option(
    "--starts", type=POSITIVE, default=20, show_default=True, metavar="N", help="Starts measured per number of masks."
)
@click.option(
    "--mask-count",
    "mask_counts",
    type=POSITIVE,
    multiple=True,
    metavar="K",
    help="A number of masks to try. May be repeated.  [default: 5 to 103]",
)
@options.seed
@options.overwrite
@options.as_json
def command(
    character: Path | None,
    template: Path | None,
    output: Path,
    resolutions: tuple[int, ...],
    expressions: int,
    overwrite: bool,
    as_json: bool,
    mask_counts: tuple[int, ...],
    **settings: int,
) -> None:
    """Repeat the paper's Table 1 and Figures 6, 7 and 8 on CHARACTER: DIR/index.html.

    The paper knows the albedo alone, so only that is measured, on all UDIM tiles.

    Without CHARACTER it makes the embedded head at 512, 1024 and 2048 texels. Scans are measured at their own size and
    at halves of it down to 256; they are never enlarged. DIR/paper.json holds every number of the page.
    """
    from reports.paper.experiments import MASK_COUNTS, Settings
    from reports.paper.report import write_paper_report
    from reports.paper.reproduction import reproduce

    if character is None and template is not None:
        raise click.UsageError("--template is for scans: the embedded character has its own")
    options.check_embedded(character, "expressions")
    with whole_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        if character is None:
            people, widths = _embedded(resolutions or EMBEDDED, expressions, settings["seed"])
            shapes: Shapes | None = partial(_embedded_shapes, seed=settings["seed"])
            origin = "the embedded character, made anew at each size"
        else:
            people, widths = _scanned(load_character(character, maps=(ALBEDO,)), resolutions)
            shapes = partial(_scanned_shapes, template=template, seed=settings["seed"]) if template else None
            origin = f"the scans’ own {widths[0]} texels and halves of it by a box filter"
        chosen = Settings(**settings, mask_counts=mask_counts or MASK_COUNTS)
        document = reproduce(people, len(widths), chosen, origin, shapes)
        document = replace(document, command=_call(character, template, output, expressions, widths, chosen))
        write_paper_report(document, folder)
    answer = replace(document, output=str(output), report=str(output / "index.html"))
    options.answer(answer, as_json, lambda: _lines(answer))


def _embedded(widths: Sequence[int], expressions: int, seed: int) -> tuple[Iterable[Character], Sequence[int]]:
    from scenes.character import make_character

    return (make_character(width, expressions, seed) for width in widths), widths


def _scanned(scans: Character, wanted: Sequence[int]) -> tuple[Iterable[Character], Sequence[int]]:
    from reports.paper.sizes import at_widths, widths_of

    widths = widths_of(scans, wanted)
    return at_widths(scans, widths), widths


def _embedded_shapes(scans: Character, seed: int) -> "ShapesFigure":
    from reports.paper.generated import figure_8
    from scenes.character import Person
    from scenes.template import embedded_template

    person = Person.make(scans.first.resolution[0], seed)
    return figure_8(scans, embedded_template(), seed, lambda shape, _: person.texture({shape: 1.0}))


def _scanned_shapes(scans: Character, template: Path, seed: int) -> "ShapesFigure":
    from facezip.rigging.template import load_template
    from reports.paper.generated import figure_8

    return figure_8(scans, load_template(template, scans.meshes.topology), seed, None)


def _call(
    character: Path | None,
    template: Path | None,
    output: Path,
    expressions: int,
    widths: Sequence[int],
    settings: "Settings",
) -> str:
    """The command that makes the same report again."""
    words: list[object] = ["--expressions", expressions] if character is None else [character]
    words += ["-o", output, *(["--template", template] if template else [])]
    for width in widths:
        words += ["--resolution", width]
    for count in settings.mask_counts:
        words += ["--mask-count", count]
    for name in ("masks", "restarts", "starts", "seed"):
        words += [f"--{name}", getattr(settings, name)]
    return call("paper", *words)


def _lines(answer: "PaperDocument") -> list[str]:
    means = answer.figure_6.rmse
    differing = [finding for finding in answer.findings if finding.stance == "differs"]
    return [
        f"{answer.output}: {answer.character.name}, mean RMSE of 255: paper {means['paper']:.2f}, "
        f"PCA(4) {means['pca_4']:.2f}, PCA(8) {means['pca_8']:.2f}, refined {means['refined']:.2f}; "
        f"{answer.seconds.total:.0f} s",
        *(f"  differs from the paper: {finding.title}. {finding.here}" for finding in differing),
        f"  open {answer.report}",
    ]
