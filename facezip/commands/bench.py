"""``facezip bench``: how long the main jobs take on this machine, as ratios to what they cannot do without."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
from click.core import ParameterSource

from facezip.bench import bench_compress
from facezip.character import Character, load_character, save_character
from facezip.commands import alarms, bench_batch, bench_maps, bench_render, options
from facezip.commands.options import megabytes
from facezip.machine import conditions

LIBRARIES = ("facezip", "numpy", "numba", "OpenImageIO")
# Compiles the same kernels as any size.
TINY = 64


@click.group("bench")
def command() -> None:
    """Measure the main jobs on this machine: each in one run beside what it is compared with."""


command.add_command(bench_render.render)
command.add_command(bench_render.metrics)
command.add_command(alarms.command)
command.add_command(bench_batch.command)
command.add_command(bench_maps.command)


@command.command("compress")
@click.option("--character", type=options.FOLDER, metavar="FOLDER", help="Scans; the embedded character if none.")
@click.option("--resolution", type=click.IntRange(256, 4096), default=1024, show_default=True, metavar="TEXELS")
@click.option("--expressions", type=click.IntRange(min=2), default=20, show_default=True, metavar="N")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, show_default=True, metavar="S")
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, metavar="N")
@options.as_json
@click.pass_context
def bench_compress_command(
    context: click.Context,
    character: Path | None,
    resolution: int,
    expressions: int,
    seed: int,
    repeats: int,
    as_json: bool,
) -> None:
    """Time `facezip compress` against decoding its input and encoding its output images.

    Both are measured in turn, in one fresh process whose peak memory is reported; kernels were compiled before, by
    a tiny run in another process. Of the repeats, the one of median ratio is reported.
    """
    if character and any(_given(context, name) for name in ("resolution", "expressions", "seed")):
        raise click.UsageError("--resolution, --expressions and --seed are of the embedded character: leave those out")
    from reports.paper.sizes import reduced

    with TemporaryDirectory(prefix="facezip-bench-") as place:
        work = Path(place)
        scans = load_character(character) if character else _embedded(work, resolution, expressions, seed)
        save_character(reduced(scans, TINY), work / "tiny")
        document = bench_compress(character or work / "character", work / "tiny", work, repeats)
    document["conditions"] = {
        **conditions(LIBRARIES),
        "character": scans.name if character else "embedded",
        "resolution": list(scans.resolution),
        "expressions": len(scans.expressions),
        "channels": scans.neutral.shape[2],
        "texels": str(scans.neutral.dtype),
        "seed": None if character else seed,
        "method": "facezip compress with its defaults",
        "io": "the same images decoded and encoded on all cores by the same functions, after each run",
        "statistic": f"the run of median ratio of {repeats}; peak memory of the process over all runs",
        "kernels": "compiled before, by a tiny run in another process; loaded in the first run",
    }
    options.answer(document, as_json, lambda: _lines(document))


@command.command("rig")
@click.option("--resolution", type=click.IntRange(64, 4096), default=512, show_default=True, metavar="TEXELS")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, show_default=True, metavar="S")
@click.option("--template-seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, metavar="S")
@options.as_json
def bench_rig_command(resolution: int, seed: int, template_seed: int, as_json: bool) -> None:
    """Rig the embedded character, whose 52 shapes are known, from 20 scans and another person's template.

    RMSE (0..255, inside the mask) of the shapes' textures to the truth, of the naive weighted sum of differences, of
    the paper's method and of ours, as packs store them; with the nuisances of a capture, and clean without them.
    """
    from reports.paper.generated import bench_rig

    document = bench_rig(resolution, seed, template_seed)
    document["conditions"] = {
        **conditions((*LIBRARIES, "scipy")),
        "character": "embedded",
        "resolution": [resolution, resolution],
        "seed": seed,
        "template": f"the same shapes on another identity, seed {template_seed}",
        "neutral": "the scanned neutral's own texture in the place of every shape's",
    }
    options.answer(document, as_json, lambda: _rig_lines(document))


def _rig_lines(document: Mapping[str, Any]) -> list[str]:
    clean, geometry, seconds = document["clean"], document["geometry"], document["seconds"]
    names = ("naive", "paper", "ours", "neutral")
    return [
        f"RMSE of {document['shapes']} generated shapes to the truth, of 255: with nuisances, and clean",
        *(f"  {name:<10} {document[name]:6.2f} {clean[name]:6.2f}" for name in names),
        f"  geometry   {geometry['ours']:.3f} of the mean displacement; template alone {geometry['transferred']:.3f}",
        f"  cond(B)    {document['condition']:.1f}, damping {document['damping']:g}, clean {clean['damping']:g}",
        f"  rigged in  {seconds['rig']:.1f} s",
    ]


def _given(context: click.Context, name: str) -> bool:
    return context.get_parameter_source(name) is ParameterSource.COMMANDLINE


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
        f"RMSE {document['rmse']:.2f} of 255 in {megabytes(document['bytes_on_gpu'])} on the GPU",
        f"  compress     {document['total_s']:8.2f} s  ({whole})",
        f"  its images   {document['io_s']:8.2f} s  ({images})",
        f"  ratio        {document['ratio']:8.2f}    ({document['conditions']['statistic']})",
        f"  peak memory  {document['peak_memory_mb']:8.0f} MB",
    ]
