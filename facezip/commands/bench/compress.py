"""``facezip bench compress``: how long the main job takes, as a ratio to what it cannot do without."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import click

from facezip.character.loading import load_character, save_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.documents.document import Document
from facezip.fit.timing import CompressBench, bench_compress
from facezip.machine.conditions import Conditions, conditions

LIBRARIES = ("facezip", "numpy", "numba", "OpenImageIO")
# Compiles the same kernels as any size.
TINY = 64


@dataclass(frozen=True, kw_only=True)
class CompressBenchConditions(Conditions):
    """What was compressed, and in words how it was measured; ``seed`` is null of scans, ``memory`` without a limit."""

    character: str
    resolution: tuple[int, int]
    expressions: int
    channels: int
    texels: str
    seed: int | None
    method: str
    memory: int | None
    io: str
    statistic: str
    kernels: str


@dataclass(frozen=True, kw_only=True)
class CompressBenchDocument(CompressBench, Document):
    """How long the main job takes beside decoding and encoding its images.

    Attributes
    ----------
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-compress/1"] = "facezip-bench-compress/1"
    conditions: CompressBenchConditions


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
        found = bench_compress(character or work / "character", work / "tiny", work, repeats, memory)
    about = CompressBenchConditions(
        **vars(conditions(LIBRARIES)),
        character=scans.name if character else "embedded",
        resolution=scans.first.resolution,
        expressions=len(scans.expressions),
        channels=scans.first.channels,
        texels=str(scans.first.neutral.dtype),
        seed=None if character else seed,
        method="facezip compress with its defaults",
        memory=memory,
        io="the same images decoded and encoded on all cores by the same functions, after each run",
        statistic=f"the run of median ratio of {repeats}; peak memory of the first",
        kernels="compiled before, by a tiny run in another process; loaded in the first run",
    )
    document = CompressBenchDocument(**vars(found), conditions=about)
    options.answer(document, as_json, lambda: _lines(document))


def _embedded(work: Path, resolution: int, expressions: int, seed: int) -> Character:
    from scenes.character import make_character

    scans = make_character(resolution, expressions, seed)
    save_character(scans, work / "character")
    return scans


def _lines(document: CompressBenchDocument) -> list[str]:
    about = document.conditions
    height, width = about.resolution
    parts = ("load", "fit", "check", "write", "measure"), ("decode", "encode")
    whole, images = (", ".join(f"{part} {getattr(document, f'{part}_s'):.2f}" for part in some) for some in parts)
    return [
        f"{about.expressions} expressions of {width} x {height} texels, "
        f"RMSE {document.rmse:.2f} of 255 in {megabytes(document.bytes_on_gpu)} at 8 bits a channel",
        f"  compress     {document.total_s:8.2f} s  ({whole})",
        f"  its images   {document.io_s:8.2f} s  ({images})",
        f"  ratio        {document.ratio:8.2f}    ({about.statistic})",
        f"  peak memory  {document.peak_memory_mb:8.0f} MB",
    ]
