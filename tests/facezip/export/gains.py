"""Gains as an artist turns them after export, and the model that is like the head then."""

import json
from dataclasses import replace

import numpy as np

from facezip.files.images import read_texture_exactly, write_texture

# More than fit in one row of their image; names are nobody's to choose but the artist's.
REGIONS = ("forehead", 'fore "head" 2', "眉")


def regions_in(folder, tiles=(1001,), size=(12, 20)):
    """Images of regions by their names, random ones of a size of their own."""
    rng = np.random.default_rng(3)
    for k in range(len(REGIONS)):
        for tile in tiles:
            write_texture(folder / f"region_{k}.{tile}.png", rng.integers(0, 256, (*size, 1), np.uint8))
    return {name: folder / f"region_{k}.<UDIM>.png" for k, name in enumerate(REGIONS)}


def masks_in(folder):
    """By name the mask ``(h, w)`` of every region of an exported tile, by its document alone."""
    document = json.loads((folder / "facezip.json").read_text(encoding="utf-8"))
    entry = document["regions"]
    image, (height, width) = read_texture_exactly(folder / entry["file"])[..., 0] / 255, entry["size"]
    places = [divmod(k, entry["columns"]) for k in range(len(document["gains"]["regions"]))]
    masks = [image[y * height : (y + 1) * height, x * width : (x + 1) * width] for y, x in places]
    return dict(zip(document["gains"]["regions"], masks, strict=True))


def turned(model, gains, masks=None):
    """The model whose blends are those of an export under gains.

    Parameters
    ----------
    gains : numbers by name of ``maps``, ``expressions`` and ``regions``.
    masks : by tile, as of :func:`masks_in`.
    """
    parts = {
        (name, tile): replace(part, differences=part.differences * np.float32(gains.get("maps", {}).get(name, 1)))
        for (name, tile), part in model.parts.items()
    }
    of_expressions = np.array([gains.get("expressions", {}).get(name, 1) for name in model.expressions])
    weights = {}
    for tile, maps in model.weights.items():
        left = np.ones(maps.shape[1:3])
        for name, gain in gains.get("regions", {}).items():
            left *= 1 - masks[tile][name] + masks[tile][name] * gain
        weights[tile] = (maps * of_expressions[:, None, None, None] * left[..., None]).astype(np.float32)
    return replace(model, parts=parts, weights=weights)
