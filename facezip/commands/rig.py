"""``facezip rig``: scans and a template in, the person's own shapes and a pack that blends them out."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from facezip.character.loading import load_character
from facezip.character.scans import NEUTRAL, Character
from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.files.obj import write_obj
from facezip.files.writing import whole_folder
from facezip.fit.methods import METHODS, compress
from facezip.fit.settings import Settings, made_with
from facezip.machine.progress import track
from facezip.pack.facts import pack_facts
from facezip.pack.parsing import read_manifest
from facezip.pack.verification import is_pack
from facezip.pack.write import write_pack
from facezip.rigging.fit import Rig, fit_rig
from facezip.rigging.rigged import MAPS, rigged
from facezip.rigging.template import Template, load_template
from facezip.rigging.weightmaps import Examples

DOCUMENT, SHAPES = "rig.json", "shapes"
FORMAT = "facezip-rig/1"


@click.command("rig")
@click.argument("character", type=options.FOLDER)
@click.option(
    "--template", type=options.FOLDER, required=True, metavar="TEMPLATE", help="Folder of shapes to generate."
)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the rig.")
@click.option(
    "--method",
    # Uniform weights have no place to put a wrinkle.
    type=click.Choice([name for name in METHODS if name != "pca"]),
    default="refined",
    show_default=True,
    help="How the textures are compressed.",
)
@click.option("--maps", type=click.Choice(MAPS), default=MAPS[0], show_default=True, help="Weight maps of the shapes.")
@options.seed
@options.overwrite
@options.as_json
def command(
    character: Path, template: Path, output: Path, method: str, maps: str, seed: int, overwrite: bool, as_json: bool
) -> None:
    """Give the person of CHARACTER the shapes of TEMPLATE, from geometry to textures.

    TEMPLATE holds neutral.obj and NAME.obj per shape, such as ARKit's 52, on any identity in CHARACTER's topology; it
    needs no textures. DIR then holds shapes/, the pack NAME.facezip whose expressions are the shapes, and rig.json:
    what every scan is made of, and how well.
    """
    begin = perf_counter()
    scans = load_character(character)
    wanted = load_template(template, scans.meshes.topology)
    started = perf_counter()
    rig = fit_rig(
        scans.meshes.neutral,
        scans.meshes.vertices - scans.meshes.neutral,
        scans.meshes.topology.faces,
        wanted.neutral,
        wanted.deltas,
    )
    seconds = {"rig": perf_counter() - started}
    settings = {"method": method, "maps": maps, "seed": seed}
    made = rigged(compress(scans, method, seed=seed), rig, wanted.shapes, maps)
    with whole_folder(output, overwrite, _is_rig) as folder:
        _write_shapes(folder / SHAPES, scans, wanted, rig)
        pack = folder / f"{scans.name}.facezip"
        stated = made_with(method, asdict(Settings(seed=seed))) | {"maps": maps, "rig": template.name}
        write_pack(made.model, pack, name=scans.name, made_with=stated)
        seconds["total"] = perf_counter() - begin
        document = _describe(scans, wanted, rig) | {
            "pack": {"path": str(output / pack.name), **pack_facts(pack, read_manifest(pack))},
            "settings": settings,
            "damping": made.damping,
            "seconds": {step: round(value, 3) for step, value in seconds.items()},
        }
        (folder / DOCUMENT).write_text(json.dumps(document, indent=1, allow_nan=False), encoding="utf-8")
    answer = {"output": str(output), **document}
    options.answer(answer, as_json, lambda: _lines(answer))


def _write_shapes(folder: Path, scans: Character, wanted: Template, rig: Rig) -> None:
    folder.mkdir()
    write_obj(folder / f"{NEUTRAL}.obj", scans.meshes.neutral, scans.meshes.topology)
    for name, delta in track(zip(wanted.shapes, rig.deltas, strict=True), "Writing the shapes", len(wanted.shapes)):
        write_obj(folder / f"{name}.obj", scans.meshes.neutral + delta, scans.meshes.topology)


def _describe(scans: Character, wanted: Template, rig: Rig) -> dict[str, Any]:
    """The rig without its meshes, in plain data; lengths in the unit of the meshes."""
    examples = Examples.of(rig.weights)
    moved = scans.meshes.vertices - scans.meshes.neutral
    sizes = (moved**2).sum(axis=2).mean(axis=1) ** 0.5
    names = scans.expressions
    return {
        "format": FORMAT,
        "character": scans.facts,
        "shapes": list(wanted.shapes),
        "example_weights": {
            name: {shape: round(float(value), 4) for shape, value in zip(wanted.shapes, row, strict=True) if value > 0}
            for name, row in zip(names, rig.weights, strict=True)
        },
        "fit": {
            name: {"rms_left": float(left), "rms_displacement": float(size)}
            for name, left, size in zip(names, rig.residuals, sizes, strict=True)
        },
        "evidence": {
            shape: {"determined": round(float(share), 4), "largest_weight": round(float(weight), 4)}
            for shape, share, weight in zip(wanted.shapes, rig.determined, rig.weights.max(axis=0), strict=True)
        },
        "unseen_shapes": [shape for shape, used in zip(wanted.shapes, rig.seen, strict=True) if not used],
        "condition": examples.condition if isfinite(examples.condition) else None,
        "rank": len(examples.weights),
    }


def _is_rig(folder: Path) -> bool:
    return (folder / DOCUMENT).is_file() and any(is_pack(path) for path in folder.glob("*.facezip"))


def _lines(answer: Mapping[str, Any]) -> list[str]:
    fit = answer["fit"]
    worst = max(fit, key=lambda name: fit[name]["rms_left"])
    left, size = fit[worst]["rms_left"], fit[worst]["rms_displacement"]
    unseen = answer["unseen_shapes"]
    pack = answer["pack"]
    gpu = f"{megabytes(pack['bytes_bc7'])} on the GPU in BC7, {pack['fetches']} fetches a pixel"
    return [
        f"{answer['output']}: {len(answer['shapes'])} shapes from {len(fit)} scans, rigged in "
        f"{answer['seconds']['rig']:.1f} s of {answer['seconds']['total']:.1f} s",
        f"  fit      worst scan {worst}: {left:.3g} left of {size:.3g} (RMS displacement, the mesh's unit)",
        f"  B        rank {answer['rank']} of {len(fit)}, condition {answer['condition']:.3g}",
        f"  unseen   {len(unseen)} shapes hardly in any scan: nearly the template's motion and the neutral's texture"
        + (f": {', '.join(unseen)}" if unseen else ""),
        f"  pack     {pack['path']}, {gpu}",
    ]
