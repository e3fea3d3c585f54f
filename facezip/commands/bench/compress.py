"""``facezip bench compress``: how long the main job takes, as a ratio to what it cannot do without."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from facezip.character.loading import load_character, save_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.fit.timing import bench_compress
from facezip.machine.conditions import conditions

LIBRARIES = ("facezip", "numpy", "numba", "OpenImageIO")
# Compiles the same kernels as any size.
TINY = 64


@click.command("compress")
@options.scans
@click.option("--resolution", type=click.IntRange(256, 8192), default=1024, show_default=True, metavar="TEXELS")
@options.expressions
@options.seed
@options.repeats
@options.memory
@options.as_json
def command(
    character: Path | None,
    resolution: int,
    expressions: int,
    seed: int,
    repeats: int,
    memory: int | None,
    as_json: bool,
) -> None:
    """Time `facezip compress` against decoding its input and encoding its output images.

    Both are measured in turn, in one fresh process, whose peak memory is reported. Kernels are compiled before, in
    another process. The repeat with the median ratio is reported.
    """
    options.check_embedded(character, "resolution", "expressions", "seed")
    from reports.paper.sizes import reduced

    with TemporaryDirectory(prefix="facezip-bench-") as place:
        work = Path(place)
        scans = load_character(character) if character else _embedded(work, resolution, expressions, seed)
        save_character(reduced(scans, TINY), work / "tiny")
        document = bench_compress(character or work / "character", work / "tiny", work, repeats, memory)
    document["conditions"] = {
        **conditions(LIBRARIES),
        "character": scans.name if character else "embedded",
        "resolution": list(scans.first.resolution),
        "expressions": len(scans.expressions),
        "channels": scans.first.neutral.shape[2],
        "texels": str(scans.first.neutral.dtype),
        "seed": None if character else seed,
        "method": "facezip compress with its defaults",
        "memory": memory,
        "io": "the same images decoded and encoded on all cores by the same functions, after each run",
        "statistic": f"the run of median ratio of {repeats}; peak memory of the first",
        "kernels": "compiled before, by a tiny run in another process; loaded in the first run",
    }
    options.answer(document, as_json, lambda: _lines(document))


def _embedded(work: Path, resolution: int, expressions: int, seed: int) -> Character:
    from scenes.character import make_character

    scans = make_character(resolution, expressions, seed)
    save_character(scans, work / "character")
    return scans


def _lines(document: Mapping[str, Any]) -> list[str]:
    height, width = document["conditions"]["resolution"]
    parts = ("load", "check", "fit", "write", "measure"), ("decode", "encode")
    whole, images = (", ".join(f"{part} {document[f'{part}_s']:.2f}" for part in some) for some in parts)
    return [
        f"{document['conditions']['expressions']} expressions of {width} x {height} texels, "
        f"RMSE {document['rmse']:.2f} of 255 in {megabytes(document['bytes_on_gpu'])} at 8 bits a channel",
        f"  compress     {document['total_s']:8.2f} s  ({whole})",
        f"  its images   {document['io_s']:8.2f} s  ({images})",
        f"  ratio        {document['ratio']:8.2f}    ({document['conditions']['statistic']})",
        f"  peak memory  {document['peak_memory_mb']:8.0f} MB",
    ]
