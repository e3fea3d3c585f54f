from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import KNOWN, Map, normals_of
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.write import write_pack
from tests.facezip.conftest import ALBEDO_KEY, random_model

# Three of them fill a sheet, and one has a range of its own.
KINDS = (
    KNOWN["albedo"], Map("cavity", "data", -2.0, 3.0), KNOWN["normal"], KNOWN["roughness"], KNOWN["specular"],
)  # fmt: skip


def with_part(model, neutral, differences, bits=8):
    """The model of one albedo with other textures."""
    return replace(model, parts={ALBEDO_KEY: Part(neutral, differences, bits)})


def grey(model):
    part = model.parts[ALBEDO_KEY]
    return with_part(model, part.neutral[..., :1].copy(), part.differences[..., :1].copy())


def smooth_model(side=64, weights=8, expressions=5, slots=4, seed=0, meshes=True):
    """Maps that a block codec and mip-maps can keep, as those of faces."""
    rng = np.random.default_rng(seed)
    model = random_model(seed, (side, side), (weights, weights), slots, expressions, meshes)
    y, x = np.mgrid[:side, :side] / side
    waves = [np.sin(9 * (x * np.cos(a) + y * np.sin(a)) + b) for a, b in rng.uniform(0, 6, (8, 2))]
    neutral = np.clip(0.5 + 0.1 * np.einsum("bc,bhw->hwc", rng.normal(0, 1, (8, 3)), waves), 0, 1)
    differences = 0.05 * np.einsum("sbc,bhw->shwc", rng.normal(0, 1, (slots, 8, 3)), waves)
    return with_part(model, neutral.astype(np.float32), differences.astype(np.float32))


def layered_model(model=random_model, kinds=KINDS, tiles=(1001,), **options):
    """Every map on every tile as a random model, all of a tile under the same weights."""
    parts, weights, whole = {}, {}, None
    for tile in tiles:
        for number, kind in enumerate(kinds):
            whole = model(seed=tile + number, meshes=True, **options)
            weights.setdefault(tile, whole.weights[1001])
            part, channels = whole.parts[ALBEDO_KEY], {"srgb": 3, "normal": 2, "data": 1}[kind.encoding]
            neutral, differences = part.neutral[..., :channels].copy(), part.differences[..., :channels].copy()
            if kind.is_normal:
                neutral = kind.encode(normals_of(2 * neutral - 1))
                differences /= np.float32(kind.unit)
            parts[kind.name, tile] = Part(neutral, differences)
    uv = whole.meshes.topology.uv * np.array([len(tiles), 1], np.float32)
    meshes = replace(whole.meshes, topology=replace(whole.meshes.topology, uv=uv))
    return CompressedTextures(whole.method, whole.expressions, kinds, parts, weights, meshes)


def files_of(folder):
    """The bytes of every file, by its place."""
    return {file.relative_to(folder): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(smooth_model(), path)
    return path
