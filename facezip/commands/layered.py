"""``facezip compress`` of characters with several maps or UDIM tiles."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from facezip.character.maps import ALBEDO
from facezip.character.surface import Surface
from facezip.commands.options import megabytes
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.joint import compress_surface
from facezip.fit.methods import made_with
from facezip.pack.errors import surface_errors
from facezip.pack.facts import memory_words, pack_facts
from facezip.pack.surface_manifest import read_any_manifest
from facezip.pack.surface_model import CompressedSurface
from facezip.pack.version_2 import read_surface, write_surface


def compress_layered(
    surface: Surface, output: Path, overwrite: bool, map_weights: Mapping[str, float], settings: dict[str, Any]
) -> dict[str, Any]:
    """Fit and write the pack, read it back, and describe it: facts, and the errors of every map."""
    model = compress_surface(surface, **settings, map_weights=map_weights)
    stated = made_with(settings["method"], settings) | ({"map_weights": dict(map_weights)} if map_weights else {})
    return write_measured_surface(surface, model, output, overwrite, stated)


def write_measured_surface(
    surface: Surface, model: CompressedSurface, output: Path, overwrite: bool, stated: dict[str, Any]
) -> dict[str, Any]:
    """As :func:`facezip.commands.compress.write_measured`, with ``errors`` by map; ``rmse`` is that of the albedo."""
    write_surface(model, output, neutral_bits=surface.neutral_bits, made_with=stated, overwrite=overwrite)
    errors = surface_errors(surface, read_surface(output))
    masked = any(part.mask is not None for part in surface.parts.values())
    return {
        **pack_facts(output, read_any_manifest(output)),
        "rmse": errors[ALBEDO]["rmse"],
        "rmse_per_expression": errors[ALBEDO]["rmse_per_expression"],
        "errors": errors,
        "region": "mask" if masked else "whole texture",
    }


def parse_map_weights(pairs: Iterable[str]) -> dict[str, float]:
    """``("normal=0.5", "roughness=2")`` as a dictionary; ``BAD_VALUE`` for anything else."""
    weights = {}
    for pair in pairs:
        name, _, weight = pair.partition("=")
        try:
            weights[name.strip()] = float(weight)
        except ValueError:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--map-weight '{pair}': write it as MAP=0.5") from None
    return weights


def layered_lines(document: Mapping[str, Any]) -> list[str]:
    """What a person reads of :func:`compress_layered`."""
    blocks, plain = memory_words(document)
    tiles = len(document["tiles"])
    return [
        f"{document['pack']}: {len(document['expressions'])} expressions, {len(document['maps'])} map(s) on {tiles} "
        f"tile{'s' * (tiles > 1)}, {document['differences']} difference textures each, method {document['method']}, "
        f"{document['seconds']:.1f} s",
        *(f"  {name:<10} {error_words(found)}" for name, found in document["errors"].items()),
        f"  GPU        {blocks}",
        f"             {plain}",
        f"  on disk    {megabytes(document['bytes_on_disk'])}",
    ]


def error_words(found: Mapping[str, Any]) -> str:
    """The error of one map, with the worst expression."""
    key, unit = ("angular_error", "degrees (mean angle)") if "angular_error" in found else ("rmse", "RMSE of 255")
    each = found[f"{key}_per_expression"]
    worst = max(each, key=each.__getitem__)
    return f"{found[key]:.2f} {unit}; worst {worst} {each[worst]:.2f}"
