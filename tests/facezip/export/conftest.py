from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import KNOWN, Map, normals_of
from facezip.pack.model import CompressedTextures
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model

# Three of them fill a sheet, and one has a range of its own.
KINDS = (
    KNOWN["albedo"], Map("cavity", "data", -2.0, 3.0), KNOWN["normal"], KNOWN["roughness"], KNOWN["specular"],
)  # fmt: skip


def grey(model):
    return CompressedTextures(
        model.neutral[..., :1].copy(),
        model.differences[..., :1].copy(),
        model.weights,
        model.expressions,
        model.method,
        model.meshes,
    )


def smooth_model(side=64, weights=8, expressions=5, slots=4, seed=0, meshes=True):
    """Maps that a block codec and mip-maps can keep, as those of faces."""
    rng = np.random.default_rng(seed)
    model = random_model(seed, (side, side), (weights, weights), slots, expressions, meshes)
    y, x = np.mgrid[:side, :side] / side
    waves = [np.sin(9 * (x * np.cos(a) + y * np.sin(a)) + b) for a, b in rng.uniform(0, 6, (8, 2))]
    model.neutral[:] = np.clip(0.5 + 0.1 * np.einsum("bc,bhw->hwc", rng.normal(0, 1, (8, 3)), waves), 0, 1)
    model.differences[:] = 0.05 * np.einsum("sbc,bhw->shwc", rng.normal(0, 1, (slots, 8, 3)), waves)
    return model


def layered_model(model=random_model, kinds=KINDS, tiles=(1001,), **options):
    """Every map on every tile as a random model, all of a tile under the same weights."""
    parts, whole = {}, None
    for tile in tiles:
        shared = None
        for number, kind in enumerate(kinds):
            whole = model(seed=tile + number, meshes=True, **options)
            shared = whole.weights if shared is None else shared
            channels = {"srgb": 3, "normal": 2, "data": 1}[kind.encoding]
            neutral, differences = whole.neutral[..., :channels].copy(), whole.differences[..., :channels].copy()
            if kind.is_normal:
                neutral = kind.fitted(normals_of(2 * neutral - 1))
                differences /= np.float32(kind.unit)
            parts[kind.name, tile] = replace(
                whole, neutral=neutral, differences=differences, weights=shared, meshes=None
            )
    uv = whole.meshes.topology.uv * np.array([len(tiles), 1], np.float32)
    meshes = replace(whole.meshes, topology=replace(whole.meshes.topology, uv=uv))
    return CompressedTextures(kinds, parts, meshes)


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(smooth_model(), path)
    return path
