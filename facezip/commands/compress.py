"""``facezip compress``: a character in, a pack out, with the error of what was written."""

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import click
import numpy as np
from click.core import ParameterSource
from numpy.typing import NDArray

from facezip.character.alignment import alignments
from facezip.character.folder import load_surface
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.character.surface import Surface
from facezip.commands import options
from facezip.commands.layered import compress_layered, layered_lines, parse_map_weights
from facezip.commands.options import megabytes
from facezip.files.names import printable
from facezip.files.values import read_values
from facezip.files.writing import check_target
from facezip.fit.choice import Choice, choose
from facezip.fit.methods import METHODS, Settings, check, compress, made_with
from facezip.machine.memory import limited
from facezip.pack.facts import memory_words, pack_facts
from facezip.pack.manifest import read_manifest
from facezip.pack.measure import mean_rmse, pack_errors
from facezip.pack.model import CompressedTextures
from facezip.pack.version_1 import is_pack, write_pack

# In the order in which a pack states them.
FIT = ("method", "differences", "weight_scale", "masks", "restarts", "seed")
# Those that hold nothing as large as a texture.
STREAMED = ("refined", "pca")
GOALS = ("target_rmse", "budget_mb")
DEFAULTS = {"method": "refined", **{name: getattr(Settings, name) for name in FIT[1:]}, **dict.fromkeys(GOALS)}


def fit_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say how to compress: those of ``FIT`` and ``GOALS``."""
    options_in_order = (
        _fit("method", None, None, click.Choice(list(METHODS))),
        _fit("differences", "R", "Number of difference textures."),
        _fit("weight_scale", "S", "Weight maps are 1/S as wide."),
        _fit("target_rmse", "X", "Choose R and S: least memory with at most this error.", float),
        _fit("budget_mb", "X", "Choose R and S: least error in this GPU memory, 8 bits a channel.", float),
        _fit("masks", "K", "Masks on the face (paper)."),
        _fit("restarts", "N", "Random starts of the stitching (paper)."),
        _fit("seed", "S", "Of what is random (paper)."),
    )
    for option in reversed(options_in_order):
        command = option(command)
    return command


def _fit(name: str, metavar: str | None, help_: str | None, kind: Any = int) -> Callable[..., Any]:
    flag, default = f"--{name.replace('_', '-')}", DEFAULTS[name]
    return click.option(flag, type=kind, default=default, show_default=True, metavar=metavar, help=help_)


@click.command("compress")
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@fit_options
@click.option("--importance", type=options.FOLDER, metavar="FILE", help="Image: how much a texel's error counts.")
@click.option(
    "--map-weight", "map_weights", multiple=True, metavar="MAP=W", help="How much a map counts.  [default: 1]"
)
@click.option("--float", "keep_floats", is_flag=True, help="Keep floats outside 0..1, with their range.")
@options.memory
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    character: Path,
    output: Path,
    importance: Path | None,
    map_weights: tuple[str, ...],
    keep_floats: bool,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
    **settings: Any,
) -> None:
    """Compress the expression textures of CHARACTER into a pack.

    CHARACTER is a folder with neutral.obj and neutral.png, and NAME.obj and NAME.png per expression (EXR, TIFF and
    16-bit PNG too). A mask.png in it limits the face region and the error. NAME.normal.png, NAME.roughness.png,
    NAME.specular.png and NAME.cavity.png beside them share the weight maps; NAME.1001.png … are UDIM tiles.
    """
    check_together(given(context), settings, importance)
    with limited(memory, scratch_folder(output)):
        document = compress_into(
            character,
            output,
            settings,
            overwrite,
            importance,
            parse_map_weights(map_weights),
            keep_floats,
            lambda line: click.echo(line, err=True),
        )
    lines = layered_lines if "errors" in document else _lines
    options.answer(document, as_json, lambda: lines(document))


def scratch_folder(output: Path) -> Path | None:
    """Where arrays wait: on the disk of the output, or where ``TMPDIR`` says; often the system's folder is memory."""
    return None if os.environ.get("TMPDIR") else next((p for p in output.absolute().parents if p.is_dir()), None)


def given(context: click.Context) -> set[str]:
    """Names of the options that stand on the command line."""
    return {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}


def check_together(names: set[str], settings: Mapping[str, Any], importance: Path | None = None) -> None:
    """Refuse options that contradict each other, before any work; ``names`` are those that somebody gave."""
    choosing, method = any(settings[goal] is not None for goal in GOALS), settings["method"]
    if choosing and names & {"differences", "weight_scale"}:
        raise click.UsageError("--target-rmse and --budget-mb choose --differences and --weight-scale: leave those out")
    if method != "refined" and (choosing or importance):
        raise click.UsageError("--target-rmse, --budget-mb and --importance need --method refined")
    if method == "refined" and names & {"masks", "restarts"}:
        raise click.UsageError("--masks and --restarts are of the paper's method: add --method paper")
    if "memory" in names and method not in STREAMED:
        raise click.UsageError(f"--memory needs --method {' or '.join(STREAMED)}: the paper's holds all textures")


def compress_into(
    character: Path,
    output: Path,
    settings: Mapping[str, Any],
    overwrite: bool,
    importance: Path | None = None,
    map_weights: Mapping[str, float] | None = None,
    keep_floats: bool = False,
    warn: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """The whole of ``facezip compress``: load, fit, write, measure; what it wrote, as ``--json`` says it.

    Parameters
    ----------
    character, output, overwrite, importance, map_weights, keep_floats : as on the command line.
    settings : the values of ``FIT`` and ``GOALS``.
    warn : is told, before the fit, which expressions are misregistered, if any.

    Raises
    ------
    FaceZipError
        For what is wrong with the input, and ``CANNOT_WRITE``.
    """
    start = perf_counter()
    fit = {name: settings[name] for name in FIT}
    check(fit["method"], Settings(**{name: value for name, value in fit.items() if name != "method"}))
    check_target(output, overwrite, is_pack)
    surface = load_surface(character, keep_floats=keep_floats)
    off = _off(surface)
    if off:
        warn(misregistered(character, off))
    if surface.ordinary:
        if map_weights:
            raise click.UsageError(f"--map-weight: {character} has no map but its albedo")
        document = _compress_albedo(surface.whole, output, fit, settings, overwrite, importance)
    else:
        if importance or any(settings[goal] is not None for goal in GOALS):
            raise click.UsageError("--target-rmse, --budget-mb and --importance are for one albedo on one tile")
        document = compress_layered(surface, output, overwrite, map_weights or {}, fit)
    return {**document, "pack": str(output), "misregistered": off, "seconds": round(perf_counter() - start, 3)}


def _compress_albedo(
    scans: Character,
    output: Path,
    fit: dict[str, Any],
    settings: Mapping[str, Any],
    overwrite: bool,
    importance: Path | None,
) -> dict[str, Any]:
    weights = None if importance is None else read_values(importance)
    stated = made_with(fit["method"], fit)
    if any(settings[goal] is not None for goal in GOALS):
        choice = _chosen(scans, settings, weights)
        model = choice.model
        stated |= {"differences": choice.trial.differences, "weight_scale": choice.trial.weight_scale}
        stated |= {goal: settings[goal] for goal in GOALS if settings[goal] is not None}
    else:
        choice, model = None, compress(scans, **fit, importance=weights)
    if importance is not None:
        stated["importance"] = importance.name
    document = write_measured(scans, model, output, overwrite, stated)
    if choice:
        document |= {"choice": {"reason": choice.reason, "tried": [asdict(trial) for trial in choice.tried]}}
    return document


def _off(surface: Surface) -> dict[str, float]:
    """The expressions that are misregistered, and by how many texels of the albedo; of several tiles on the worst."""
    off: dict[str, float] = {}
    for part in surface.of_map(ALBEDO):
        for name, one in alignments(part, quick=True).items():
            if not one.registered:
                off[name] = max(round(one.rms, 2), off.get(name, 0.0))
    return off


def misregistered(character: str | Path, off: Mapping[str, float]) -> str:
    """The warning about expressions and how many texels they are off."""
    worst = sorted(off, key=off.__getitem__, reverse=True)[:3]
    some = ", ".join(f"{name} by {off[name]:.1f} texels" for name in worst) + (", ..." if len(off) > len(worst) else "")
    verb = "is" if len(off) == 1 else "are"
    remedy = f"textures will blur; see 'facezip check {character}'"
    return printable(f"facezip: warning: {len(off)} of the expressions {verb} off the neutral ({some}); {remedy}")


def _chosen(scans: Character, settings: Mapping[str, Any], weights: NDArray[np.float32] | None) -> Choice:
    target, budget = (settings[goal] for goal in GOALS)
    return choose(scans, target_rmse=target, budget_bytes=None if budget is None else budget * 1e6, importance=weights)


def write_measured(
    scans: Character, model: CompressedTextures, output: Path, overwrite: bool, stated: dict[str, Any]
) -> dict[str, Any]:
    """Write the pack, read it back, and describe it: facts, ``rmse`` and ``rmse_per_expression`` (0..255).

    ``stated`` is what the pack says of how it was made.
    """
    bits = 8 if scans.neutral.itemsize == 1 else 16
    write_pack(model, output, neutral_bits=bits, made_with=stated, overwrite=overwrite)
    errors = pack_errors(scans, output)
    return {
        **pack_facts(output, read_manifest(output)),
        "rmse": mean_rmse(errors),
        "rmse_per_expression": errors,
        "region": "whole texture" if scans.mask is None else "mask",
    }


def _lines(document: dict[str, Any]) -> list[str]:
    errors = document["rmse_per_expression"]
    worst, best = max(errors, key=errors.__getitem__), min(errors, key=errors.__getitem__)
    blocks, plain = memory_words(document)
    chosen = [f"  chosen   {document['choice']['reason']}"] if "choice" in document else []
    return [
        f"{document['pack']}: {len(errors)} expressions in {document['differences']} difference textures, "
        f"method {document['method']}, {document['seconds']:.1f} s",
        f"  RMSE     {document['rmse']:.2f} of 255 ({document['region']}); worst {worst} {errors[worst]:.2f}, "
        f"best {best} {errors[best]:.2f}",
        *chosen,
        f"  GPU      {blocks}",
        f"           {plain}",
        f"  on disk  {megabytes(document['bytes_on_disk'])}",
    ]
