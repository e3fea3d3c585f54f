"""Packs of several maps and tiles without a fit, and scans: what they show is random, and known."""

from dataclasses import replace

import numpy as np

from facezip.character.maps import KNOWN, Map
from facezip.character.scans import Character, Stack
from facezip.character.tiles import place_of
from facezip.pack.model import CompressedTextures, Part
from tests.facezip.conftest import masked, random_model

SKIN = ("albedo", "normal", "roughness")
# What people call data, and measure in units of their own.
DEPTH = Map("depth", "data", -0.25, 0.75)


def random_maps(
    maps=SKIN, tiles=(1001,), size=(24, 40), weights=(3, 5), slots=4, expressions=3, bits=8, channels=None, masks=0
):
    """A model of those maps (names of known ones, or kinds) on those tiles, whose mesh spreads over all of them."""
    rng = np.random.default_rng(7)
    kinds = tuple(KNOWN[kind] if isinstance(kind, str) else kind for kind in maps)
    base = random_model(size=size, weights=weights, slots=slots, expressions=expressions, meshes=True)
    parts = {}
    for kind in kinds:
        depth = (channels or {}).get(kind.name, 3 if kind.encoding == "srgb" else 2 if kind.is_normal else 1)
        for tile in tiles:
            # Of normals, slopes of up to 45 degrees and beyond; of others, anything.
            neutral = 0.5 + rng.uniform(-0.05, 0.05, (*size, depth)) if kind.is_normal else rng.random((*size, depth))
            spread = 0.01 if kind.is_normal else 0.1
            differences = rng.normal(0, spread, (slots, *size, depth))
            parts[kind.name, tile] = Part(neutral.astype(np.float32), differences.astype(np.float32), bits)
    combined = {tile: rng.normal(0, 1, (expressions, *weights, slots)).astype(np.float32) for tile in tiles}
    meshes = replace(base.meshes, topology=spread_over(base.meshes.topology, tiles))
    model = CompressedTextures("refined", base.expressions, kinds, parts, combined, meshes)
    return masked(model, masks) if masks else model


def spread_over(topology, tiles):
    """The layout with its faces dealt out to the tiles in turn: each has corners of its own there."""
    faces = topology.face_uv.shape[0]
    places = np.array([place_of(tiles[f % len(tiles)]) for f in range(faces)], np.float32)
    uv = topology.uv[topology.face_uv] + places[:, None]
    return replace(topology, uv=uv.reshape(-1, 2), face_uv=np.arange(3 * faces, dtype=np.int32).reshape(-1, 3))


def random_scans(model):
    """Scans with the expressions, maps and tiles of a model, of 8 bits, normals as slopes of up to 28 degrees."""
    rng = np.random.default_rng(1)
    normal = {kind.name: kind.is_normal for kind in model.maps}
    stacks = {}
    for (name, tile), part in model.parts.items():
        low, high, dtype = (31000, 34500, np.uint16) if normal[name] else (0, 256, np.uint8)
        counts = (), (len(model.expressions),)
        stacks[name, tile] = Stack(*(rng.integers(low, high, (*count, *part.neutral.shape), dtype) for count in counts))
    return Character("random", model.expressions, model.meshes, model.maps, stacks)
