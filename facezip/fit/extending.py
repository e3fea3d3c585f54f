"""``facezip extend`` as one call: new expressions into a pack, and what each loses against a fit of all."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from facezip.character.loading import load_character
from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.files.packs import is_pack
from facezip.files.writing import check_target
from facezip.fit.documents import ExtendDocument
from facezip.fit.extension import beside_neutral_of, extended
from facezip.fit.full import full_fit_errors
from facezip.fit.pipeline import check_registration
from facezip.machine.rows import by_rows
from facezip.names import folded
from facezip.pack.errors import Errors, MapErrors, pack_errors
from facezip.pack.extended import write_extended
from facezip.pack.facts import pack_facts
from facezip.pack.manifest import Manifest
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import StoredTextures
from facezip.pack.read import read_bytes
from facezip.pack.same_neutral import check_same_neutral

# A fit of all is advised for an expression that would lose more than a third of its error there, and half a level.
MUCH, MUCH_IN_LEVELS = 1.5, 0.5


def extend_into(
    pack: Path,
    character: Path,
    output: Path,
    overwrite: bool = False,
    quick: bool = False,
    warn: Callable[[str], None] = lambda _: None,
) -> ExtendDocument:
    """Add the expressions of a character that a pack lacks, under the textures that it has, and measure them.

    Parameters
    ----------
    pack, character, output, overwrite : as on the command line.
    quick : whether the fit of all expressions, beside which the new ones are judged, is left out.
    warn : is told which expressions are misregistered, if any.

    Raises
    ------
    FaceZipError
        What is wrong with pack or scans; ``BAD_VALUE`` where nothing is new; ``CANNOT_WRITE``.
    """
    start = perf_counter()
    check_target(output, overwrite, is_pack)
    before, stored = read_bytes(pack)
    model = stored.dequantised()
    maps = tuple(kind.name for kind in stored.maps)
    scans = load_character(character, maps=maps, fewest=1)
    check_same_neutral(scans, stored, model, pack)
    kept, added = _names(pack, stored, scans)
    registration = check_registration(scans, added, character, warn)
    scans = beside_neutral_of(stored, scans)
    new, weights = _only(scans, added), _map_weights(before)
    whole, cut = extended(stored, model, new, weights)
    earlier = before.made_with.get("extended_by")
    made = {"extended_by": [*(earlier if isinstance(earlier, tuple) else ()), *added]}
    full = None
    if not quick:
        # Before the pack is written: what is refused leaves none behind.
        full = full_fit_errors(pack, model, scans, new, before.made_with.get("nonnegative") is True, weights)
    write_extended(pack, before, whole, output, made_with=made, overwrite=overwrite)
    errors = pack_errors(new, output)
    return ExtendDocument(
        **vars(pack_facts(output, read_manifest(output))),
        **vars(registration),
        pack=str(output),
        added=added,
        kept=kept,
        errors=errors,
        full_fit=full,
        loss={name: _loss(errors[name], full[name]) for name in errors} if full else None,
        cut=cut,
        advised=[name for name in added if full and _much(errors, full, name)],
        region="mask" if scans.masked else "whole texture",
        seconds=round(perf_counter() - start, 3),
    )


def _names(pack: Path, stored: StoredTextures, scans: Character) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Those that the pack has, which stay as they are, and those that it lacks."""
    kept = tuple(name for name in scans.expressions if name in stored.expressions)
    added = tuple(name for name in scans.expressions if name not in stored.expressions)
    alike = {folded(name): name for name in stored.expressions}
    for name in added:
        if folded(name) in alike:
            there = f"has '{alike[folded(name)]}', and {scans.name} '{name}': many file systems take them for one"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {there}; rename one")
    if not added:
        reason = f"has all {len(kept)} expressions of {scans.name} already; nothing to add"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {reason}")
    return kept, added


def _only(scans: Character, names: tuple[str, ...]) -> Character:
    """The scans of some expressions."""
    chosen = [scans.index(name) for name in names]
    stacks = {key: replace(stack, textures=_chosen(stack.textures, chosen)) for key, stack in scans.stacks.items()}
    return replace(
        scans, expressions=names, meshes=replace(scans.meshes, vertices=scans.meshes.vertices[chosen]), stacks=stacks
    )


def _chosen(textures: Texels, chosen: Sequence[int]) -> Texels:
    shape = len(chosen), *textures.shape[1:]
    return by_rows(lambda rows: textures[chosen, rows], shape, textures.dtype, axis=1)


def _map_weights(before: Manifest) -> dict[str, float]:
    """What the pack says of how much maps count, as far as it is of any use: it is written for people."""
    stated = before.made_with.get("map_weights")
    names = {entry.name for entry in before.maps}
    pairs = stated.items() if isinstance(stated, Mapping) else ()
    return {name: float(w) for name, w in pairs if name in names and type(w) in (int, float) and 0 < w <= 1e6}


def _loss(ours: MapErrors, full: MapErrors) -> dict[str, float]:
    return {name: error - full.per_expression[name] for name, error in ours.per_expression.items()}


def _much(errors: Errors, full: Errors, name: str) -> bool:
    """Of any map, in levels of 255 or in degrees."""
    pairs = [(errors[kind].per_expression[name], full[kind].per_expression[name]) for kind in errors]
    return any(ours > MUCH * theirs and ours - theirs > MUCH_IN_LEVELS for ours, theirs in pairs)
