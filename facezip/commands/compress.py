"""``facezip compress``: a character in, a pack out, with the error of what was written."""

from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import click
from click.core import ParameterSource

from facezip.character import Character
from facezip.choice import choose
from facezip.commands import options
from facezip.commands.facts import pack_facts
from facezip.commands.layered import compress_layered, layered_lines, parse_map_weights
from facezip.commands.options import megabytes
from facezip.manifest import read_manifest
from facezip.measure import mean_rmse, model_errors
from facezip.methods import METHODS, compress
from facezip.model import CompressedTextures
from facezip.pack import read_pack, write_pack
from facezip.surface.folder import load_surface
from facezip.textures import read_values


@click.command("compress")
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@click.option("--method", type=click.Choice(list(METHODS)), default="refined", show_default=True)
@click.option("--differences", default=4, show_default=True, metavar="R", help="Number of difference textures.")
@click.option("--weight-scale", default=8, show_default=True, metavar="S", help="Weight maps are S times smaller.")
@click.option("--target-rmse", type=float, metavar="X", help="Choose R and S: least memory with at most this error.")
@click.option("--budget-mb", type=float, metavar="X", help="Choose R and S: least error in this GPU memory.")
@click.option("--importance", type=options.FOLDER, metavar="FILE", help="Image: how much a texel's error counts.")
@click.option(
    "--map-weight", "map_weights", multiple=True, metavar="MAP=W", help="How much a map counts.  [default: 1]"
)
@click.option("--float", "keep_floats", is_flag=True, help="Keep floats outside 0..1, with their range.")
@click.option("--masks", default=53, show_default=True, metavar="K", help="Masks on the face (paper).")
@click.option("--restarts", default=100, show_default=True, metavar="N", help="Random starts of the stitching (paper).")
@click.option("--seed", default=0, show_default=True, metavar="S")
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    character: Path,
    output: Path,
    target_rmse: float | None,
    budget_mb: float | None,
    importance: Path | None,
    map_weights: tuple[str, ...],
    keep_floats: bool,
    overwrite: bool,
    as_json: bool,
    **settings: Any,
) -> None:
    """Compress the expression textures of CHARACTER into a pack.

    CHARACTER is a folder with neutral.obj and neutral.png, and NAME.obj and NAME.png per expression (EXR, TIFF and
    16-bit PNG too). A mask.png in it limits the face region and the error. NAME.normal.png, NAME.roughness.png,
    NAME.specular.png and NAME.cavity.png beside them share the weight maps; NAME.1001.png … are UDIM tiles.
    """
    choosing = target_rmse is not None or budget_mb is not None
    _check_together(context, choosing, settings["method"], importance)
    start = perf_counter()
    surface = load_surface(character, keep_floats=keep_floats)
    if not surface.ordinary:
        if choosing or importance:
            raise click.UsageError("--target-rmse, --budget-mb and --importance are for one albedo on one tile")
        document = compress_layered(surface, output, overwrite, parse_map_weights(map_weights), settings)
        document["seconds"] = round(perf_counter() - start, 3)
        options.answer(document, as_json, lambda: layered_lines(document))
        return
    if map_weights:
        raise click.UsageError(f"--map-weight: {character} has no map but its albedo")
    scans = surface.whole
    weights = None if importance is None else read_values(importance)
    choice = None
    if choosing:
        budget = None if budget_mb is None else budget_mb * 1e6
        choice = choose(scans, target_rmse=target_rmse, budget_bytes=budget, importance=weights)
        settings |= {"differences": choice.trial.differences, "weight_scale": choice.trial.weight_scale}
        settings |= {"target_rmse": target_rmse, "budget_mb": budget_mb}
    model = choice.model if choice else compress(scans, **settings, importance=weights)
    made_with = settings if importance is None else {**settings, "importance": importance.name}
    document = write_measured(scans, model, output, overwrite, made_with)
    document |= {"pack": str(output)}
    if choice:
        document |= {"choice": {"reason": choice.reason, "tried": [asdict(trial) for trial in choice.tried]}}
    document["seconds"] = round(perf_counter() - start, 3)
    options.answer(document, as_json, lambda: _lines(document))


def _check_together(context: click.Context, choosing: bool, method: str, importance: Path | None) -> None:
    """Refuse options that contradict each other, before any work."""
    given = {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}
    if choosing and given & {"differences", "weight_scale"}:
        raise click.UsageError("--target-rmse and --budget-mb choose --differences and --weight-scale: leave those out")
    if method != "refined" and (choosing or importance):
        raise click.UsageError("--target-rmse, --budget-mb and --importance need --method refined")
    if method == "refined" and given & {"masks", "restarts"}:
        raise click.UsageError("--masks and --restarts are of the paper's method: add --method paper")


def write_measured(
    scans: Character, model: CompressedTextures, output: Path, overwrite: bool, settings: dict[str, Any]
) -> dict[str, Any]:
    """Write the pack, read it back, and describe it: facts, ``rmse`` and ``rmse_per_expression`` (0..255)."""
    bits = 8 if scans.neutral.itemsize == 1 else 16
    write_pack(model, output, neutral_bits=bits, made_with=settings, overwrite=overwrite)
    errors = model_errors(scans, read_pack(output))
    return {
        **pack_facts(output, read_manifest(output)),
        "rmse": mean_rmse(errors),
        "rmse_per_expression": errors,
        "region": "whole texture" if scans.mask is None else "mask",
    }


def _lines(document: dict[str, Any]) -> list[str]:
    errors = document["rmse_per_expression"]
    worst, best = max(errors, key=errors.__getitem__), min(errors, key=errors.__getitem__)
    gpu, raw, disk = (megabytes(document[key]) for key in ("bytes_on_gpu", "bytes_raw", "bytes_on_disk"))
    saving = document["bytes_raw"] / document["bytes_on_gpu"]
    chosen = [f"  chosen   {document['choice']['reason']}"] if "choice" in document else []
    return [
        f"{document['pack']}: {len(errors)} expressions in {document['differences']} difference textures, "
        f"method {document['method']}, {document['seconds']:.1f} s",
        f"  RMSE     {document['rmse']:.2f} of 255 ({document['region']}); worst {worst} {errors[worst]:.2f}, "
        f"best {best} {errors[best]:.2f}",
        *chosen,
        f"  GPU      {gpu} instead of {raw} ({saving:.1f}x less), {document['fetches']} fetches a pixel",
        f"  on disk  {disk}",
    ]
