"""``facezip bench scaling``: how the main job's time grows with the size of the textures."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click

from facezip.character.loading import save_character
from facezip.commands import options
from facezip.commands.bench.compress import LIBRARIES, TINY
from facezip.commands.words import call
from facezip.files.writing import whole_folder
from facezip.fit.refine import alternations
from facezip.fit.timing import bench_compress
from facezip.machine.conditions import conditions

if TYPE_CHECKING:
    from reports.scaling import ScalingDocument, ScalingSize

REPORT_FILE = "scaling.json"
SIDES = (512, 1024, 2048, 4096)


@click.command("scaling")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option(
    "--resolution",
    "resolutions",
    type=click.IntRange(256, 8192),
    multiple=True,
    default=SIDES,
    show_default=True,
    metavar="TEXELS",
    help="A side of square textures; give it once for each size.",
)
@options.expressions
@options.seed
@options.repeats
@options.memory
@options.overwrite
@options.as_json
def command(
    output: Path,
    resolutions: tuple[int, ...],
    expressions: int,
    seed: int,
    repeats: int,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Compress the embedded character at several sizes: seconds per megatexel in DIR/index.html.

    Each size as `facezip bench compress` measures it, in a fresh process. DIR/scaling.json holds every number.
    """
    from reports.scaling import Heading, ScalingConditions, ScalingDocument, write_scaling_report

    sides = sorted(set(resolutions))
    with whole_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        sizes = [_measured(side, expressions, seed, repeats, memory) for side in sides]
        cost = [one.seconds_per_megatexel for one in sizes]
        document = ScalingDocument(
            character=Heading(name="Seconds per megatexel"),
            sizes=sizes,
            factor=max(cost) / min(cost),
            conditions=ScalingConditions(
                **vars(conditions(LIBRARIES)),
                character="embedded",
                expressions=expressions,
                seed=seed,
                memory="no limit" if memory is None else f"{memory / 1e6:.0f} MB",
                method="facezip compress with its defaults",
                statistic=f"the run of median ratio of {repeats} at each size",
            ),
            command=f"{call('bench', 'scaling', '-o', output)} "
            + " ".join(f"--resolution {side}" for side in sides)
            + f" --expressions {expressions} --seed {seed} --repeats {repeats}"
            + ("" if memory is None else f" --memory {memory / 1e6:.0f}M"),
        )
        write_scaling_report(document, folder)
    answer = replace(document, output=str(output), report=str(output / "index.html"))
    options.answer(answer, as_json, lambda: _lines(answer))


def _measured(side: int, expressions: int, seed: int, repeats: int, memory: int | None) -> "ScalingSize":
    """What :func:`facezip.fit.timing.bench_compress` finds at one size, and its cost."""
    from reports.scaling import ScalingSize
    from scenes.character import make_character

    with TemporaryDirectory(prefix="facezip-bench-") as place:
        work = Path(place)
        for name, texels in (("character", side), ("tiny", TINY)):
            save_character(make_character(texels, expressions, seed), work / name)
        found = bench_compress(work / "character", work / "tiny", work, repeats, memory)
    megatexels = side * side / 1e6
    return ScalingSize(
        resolution=side,
        **vars(found),
        seconds_per_megatexel=found.total_s / megatexels,
        alternations=alternations(side * side),
        alternation_s=found.fit_s / alternations(side * side),
    )


def _lines(answer: "ScalingDocument") -> list[str]:
    sizes = [
        f"  {one.resolution:>5}²  {one.total_s:8.2f} s  {one.seconds_per_megatexel:6.2f} s per megatexel, "
        f"{one.ratio:.2f} times its images, peak {one.peak_memory_mb:.0f} MB"
        for one in answer.sizes
    ]
    return [
        f"{answer.conditions.expressions} expressions: dearest megatexel {answer.factor:.2f} x the cheapest",
        *sizes,
        f"  open {answer.report}",
    ]
