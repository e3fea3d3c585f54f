"""How far what an engine shows is from what the pack holds: by the codec at full size, by mip-maps at every other."""

from collections.abc import Mapping, Sequence
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.export.levels import Level, as_model
from facezip.export.mips import Pyramid
from facezip.export.source import Source
from facezip.model import CompressedTextures
from facezip.progress import track

# Below this side a head is a few pixels, and a level has too few texels for a mean over them to say anything.
SMALLEST = 8
# A mean over a few expressions is as good as one over all: that many texels are looked at, of at least four of them.
TEXELS_MEASURED, LEAST = 2**24, 4
# Blends that the fit has not seen: neighbours in the order of expressions, half and half.
BLENDS = 8

Blend = Mapping[str, float]


def codec_errors(source: Source, pyramid: Pyramid, level: Level) -> dict[str, Any]:
    """RMSE (0..255) that a codec adds to each map's texels and to the textures of expressions, inside the chart."""
    seen, share = as_model(source, level), pyramid.shares[0]
    errors = {
        name: _rmse(seen.reconstruct(name) - source.model.reconstruct(name), share)
        for name in track(source.model.expressions, "Measuring", len(source.model.expressions))
    }
    return {"maps": level.loss, "rmse": float(np.mean([*errors.values()])), "rmse_per_expression": errors}


def mip_errors(
    source: Source, pyramid: Pyramid, plain: Sequence[Level], **candidates: Sequence[Level]
) -> list[dict[str, Any]]:
    """How far levels are from the light of the blend, averaged; one document a level.

    Parameters
    ----------
    source, pyramid : the pack, and which texels count.
    plain : every map averaged on its own and stored as it is.
    **candidates : levels by name, of maps as an engine sees them.

    Returns
    -------
    For each level its ``size``, and RMSE (0..255) inside the chart: ``product_gap``, how far the encoded mip of a blend
    is from the blend of ``plain`` mips; for each candidate its error over expressions, and (``NAME_blends``) over
    blends of them that no fit has seen.
    """
    names = source.model.expressions
    most = max(TEXELS_MEASURED // pyramid.shares[0].size, LEAST)
    some = names[:: -(-len(names) // most)]
    alone: list[Blend] = [{name: 1.0} for name in some]
    mixed: list[Blend] = [dict.fromkeys(pair, 0.5) for pair in islice(pairwise(names), min(most, BLENDS))]
    count = sum(min(size) >= SMALLEST for size in pyramid.sizes)
    models = {
        name: [as_model(source, level) for level in levels[:count]]
        for name, levels in {"plain": plain, **candidates}.items()
    }
    rows: list[dict[str, Any]] = [{"size": list(size)} for size in pyramid.sizes[:count]]
    kinds: dict[str, list[Blend]] = {"": alone, "_blends": mixed}
    for kind, blends in kinds.items():
        errors = [_errors_of(source, pyramid, blend, models) for blend in track(blends, "Measuring", len(blends))]
        for row, levels in zip(rows, zip(*errors, strict=True), strict=False):
            row |= {name + kind: float(np.mean([level[name] for level in levels])) for name in levels[0]}
    return rows


def _errors_of(
    source: Source, pyramid: Pyramid, blend: Blend, models: Mapping[str, Sequence[CompressedTextures]]
) -> list[dict[str, float]]:
    whole = source.model.blend(blend)
    found = []
    for number, (light, encoded, share) in enumerate(
        zip(pyramid.light(whole), pyramid.levels(whole), pyramid.shares, strict=True)
    ):
        if min(share.shape) < SMALLEST:
            break
        shown = {name: levels[number].blend(blend) for name, levels in models.items()}
        errors = {name: _rmse(texture - light, share) for name, texture in shown.items()}
        found.append({"product_gap": _rmse(shown["plain"] - encoded, share)} | errors)
    return found


def _rmse(gap: NDArray[np.float32], share: NDArray[np.float32]) -> float:
    squares = np.square(gap).mean(axis=2)
    return float(255 * np.sqrt((squares * share).sum(dtype=np.float64) / share.sum(dtype=np.float64)))
