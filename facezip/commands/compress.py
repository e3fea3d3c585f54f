"""``facezip compress``: a character in, a pack out, with the error of what was written."""

import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.fit_options import check_together, fit_options, request_of
from facezip.commands.words import cleaning_words, error_words, masks_words, megabytes, memory_words
from facezip.fit.documents import CompressDocument, KeptFacts
from facezip.fit.kept_files import Keeping
from facezip.fit.pipeline import Request, compress_into
from facezip.machine.memory import beside, limited
from facezip.pack.facts import several


@click.command("compress")
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@fit_options
@click.option(
    "--lock",
    "locks",
    multiple=True,
    metavar="LAYER=FILE",
    help="Keep a painted layer byte for byte, and fit the rest around it: difference_0=wrinkles.png for the albedo, "
    "normal.difference_0=… for another map. May be repeated (refined).",
)
@click.option(
    "--lock-weights",
    "painted",
    multiple=True,
    metavar="NAME=FILE",
    help="Keep painted weight maps of expression NAME byte for byte: a channel for each layer, or a grey image of one, "
    "NAME.difference_0=…, as 'decompress --weights' writes them; may be repeated (refined).",
)
@click.option(
    "--region",
    "regions",
    multiple=True,
    metavar="NAME=FILE",
    help="Mask of a region, white inside: forehead=mask.png; may be repeated.",
)
@click.option(
    "--keep-region",
    "keep",
    multiple=True,
    metavar="NAME",
    help="Keep that region as it is in the pack of --from, byte for byte, and fit the rest around it; may be repeated "
    "(refined).",
)
@click.option("--from", "older", type=options.FOLDER, metavar="PACK", help="The older pack of --keep-region.")
@options.memory
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    character: Path,
    output: Path,
    locks: tuple[str, ...],
    painted: tuple[str, ...],
    regions: tuple[str, ...],
    keep: tuple[str, ...],
    older: Path | None,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Compress the expression textures of CHARACTER into a pack.

    CHARACTER is a folder with neutral.obj, neutral.png, and NAME.obj and NAME.png for each expression, or a .glb or
    .gltf. PNG, TIFF, OpenEXR and JPEG are read. A mask.png limits the face region and the error. NAME.normal.png,
    NAME.roughness.png, NAME.specular.png and NAME.cavity.png share the weight maps. NAME.1001.png … are UDIM tiles.
    Files of other names are listed in character.toml (docs/maps.md).
    """
    check_together(options.on_line(context), given)
    request = replace(
        request_of(given),
        locks=_named("lock", locks, "difference_0"),
        painted=_named("lock-weights", painted, "NAME"),
        keeping=_keeping(_named("region", regions, "NAME"), keep, older),
    )
    _check_kept(request)
    with limited(memory, beside(output)):
        document = compress_into(character, output, request, overwrite, lambda line: print(line, file=sys.stderr))
    options.answer(document, as_json, lambda: _lines(document))


def _named(option: str, pairs: Iterable[str], example: str) -> dict[str, Path]:
    """``NAME=FILE`` by name."""
    found: dict[str, Path] = {}
    for pair in pairs:
        name, _, file = pair.partition("=")
        if not name or not file or name in found:
            raise click.UsageError(f"--{option} '{pair}': write it as {example}=FILE, each name once")
        found[name] = Path(file)
    return found


def _keeping(images: Mapping[str, Path], names: tuple[str, ...], pack: Path | None) -> Keeping | None:
    """The regions that stay; None where none is asked for."""
    if not (images or names or pack):
        return None
    if not (images and names and pack):
        raise click.UsageError("--keep-region NAME needs --region NAME=FILE and --from PACK, and they need it")
    stems = {name: {name, name.rpartition(".")[0]} for name in images}
    for name in names:
        if not any(name in some for some in stems.values()):
            raise click.UsageError(f"--keep-region {name}: say where it is with --region {name}=FILE")
    for name, some in stems.items():
        if not some & {*names}:
            raise click.UsageError(f"--region {name}: nothing is done there without --keep-region {name}")
    return Keeping(pack, images, tuple(dict.fromkeys(names)))


def _check_kept(request: Request) -> None:
    """Refuse what does not go together with what stays as it is."""
    asked = {"--lock": request.locks, "--lock-weights": request.painted, "--keep-region": request.keeping}
    for flag in (flag for flag, given in asked.items() if given):
        if request.method != "refined":
            raise click.UsageError(f"{flag} needs --method refined")
        if request.goals:
            raise click.UsageError(f"--target-rmse and --budget-mb choose the number of layers: leave {flag} out")
        if request.settings.sparse is not None and flag != "--lock":
            raise click.UsageError(f"--sparse chooses anew which layers an expression uses: leave it or {flag} out")
    if request.keeping and (request.locks or request.painted):
        raise click.UsageError(
            "--keep-region keeps all layers and weights in a region: leave --lock and --lock-weights out"
        )
    if request.keeping and request.settings.nonnegative:
        raise click.UsageError("--keep-region keeps the range of weights that the pack has: leave --nonnegative out")


def _lines(document: CompressDocument) -> list[str]:
    blocks, plain = memory_words(document)
    each = "s" * (document.differences != 1) + " each" * (len(document.maps) > 1)
    return [
        f"{document.pack}: {len(document.expressions)} expressions{several(document)} in "
        f"{document.differences} difference texture{each}, method {document.method}, "
        f"{document.seconds:.1f} s",
        *(f"  cleaned    {line}" for line in cleaning_words(document.cleaning)),
        *(f"  {name:<10} {error_words(found)} ({document.region})" for name, found in document.errors.items()),
        *([f"  kept       {_kept_words(document.kept)}"] if document.kept else []),
        *([f"  masks      {masks_words(document.masks)}"] if document.masks else []),
        *([f"  chosen     {document.choice.reason}"] if document.choice else []),
        f"  GPU        {blocks}",
        f"             {plain}",
        f"  on disk    {megabytes(document.bytes_on_disk)}, geometry {megabytes(document.bytes_geometry)} of it",
    ]


def _kept_words(kept: KeptFacts) -> str:
    """What is kept of an older pack, and the errors on either side of its border."""
    sides = [("inside", kept.rmse_inside), ("outside", kept.rmse_outside)]
    errors = ", ".join(f"{error:.2f} {side}" for side, error in sides if error is not None)
    return f"{', '.join(kept.regions)}, {kept.share:.0%} of the face; albedo {errors}"
