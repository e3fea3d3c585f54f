from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.meshes import Meshes
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE
from facezip.files.obj import Topology
from facezip.fit.methods import compress
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures, Part
from tests.peaks import peak_of

ALBEDO_KEY = (ALBEDO, FIRST_TILE)


def grid_topology(side):
    """A flat sheet of side x side vertices over the whole unit square."""
    v, u = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side), indexing="ij")
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + side + 1], 1), np.stack([corner, corner + side + 1, corner + side], 1)]
    ).astype(np.int32)
    return Topology(faces, np.stack([u, v], 2).reshape(-1, 2).astype(np.float32), faces)


def random_character(seed=0, expressions=5, side=32, grid=9, dtype=np.uint8):
    """Smooth random textures that change locally, on a sheet."""
    rng = np.random.default_rng(seed)
    topology = grid_topology(grid)
    vertices = np.c_[topology.uv * 20, np.zeros(len(topology.uv))].astype(np.float32)
    y, x = np.mgrid[:side, :side] / side
    bumps = [np.exp(-40 * ((x - a) ** 2 + (y - b) ** 2)) for a, b in rng.random((2 * expressions, 2))]
    mixing = rng.normal(0, 0.2, (expressions, len(bumps), 3))
    textures = (
        0.5 + np.einsum("nbc,bhw->nhwc", mixing, np.array(bumps)) + rng.normal(0, 0.01, (expressions, side, side, 3))
    )
    neutral = np.clip(0.5 + rng.normal(0, 0.05, (side, side, 3)), 0, 1)
    maximum = 1 if dtype == np.float32 else np.iinfo(dtype).max
    moved = (vertices + rng.normal(0, 0.1, (expressions, *vertices.shape))).astype(np.float32)
    stack = Stack((neutral * maximum).astype(dtype), (np.clip(textures, 0, 1) * maximum).astype(dtype))
    return one_albedo(stack, Meshes(topology, vertices, moved))


def one_albedo(stack, meshes=None, expressions=None):
    """A character of one albedo on one tile; on a sheet that nothing moves where no meshes are given."""
    count = len(stack.textures)
    if meshes is None:
        topology = grid_topology(9)
        flat = np.c_[topology.uv * 20, np.zeros(len(topology.uv))].astype(np.float32)
        meshes = Meshes(topology, flat, np.repeat(flat[None], count, axis=0))
    names = expressions or tuple(f"expr_{n}" for n in range(count))
    return Character("sheet", names, meshes, (KNOWN[ALBEDO],), {ALBEDO_KEY: stack})


def with_albedo(character, **changes):
    """The character with parts of its albedo replaced: neutral, textures, mask."""
    stack = replace(character.stacks[ALBEDO_KEY], **changes)
    return replace(character, stacks={**character.stacks, ALBEDO_KEY: stack})


def random_model(seed=0, size=(24, 40), weights=(3, 5), slots=4, expressions=3, meshes=False):
    rng = np.random.default_rng(seed)
    sheet = grid_topology(4)
    neutral = rng.normal(size=(16, 3)).astype(np.float32)
    geometry = Meshes(sheet, neutral, neutral + rng.normal(size=(expressions, 16, 3)).astype(np.float32))
    part = Part(
        (rng.integers(0, 256, (*size, 3)) / 255).astype(np.float32),
        rng.normal(0, 0.1, (slots, *size, 3)).astype(np.float32),
    )
    maps = rng.normal(0, 1, (expressions, *weights, slots)).astype(np.float32)
    names = tuple(f"expr_{n}" for n in range(expressions))
    return one_part(part, maps, names, geometry if meshes else None)


def masked(model, count=6):
    """The model with weight maps that are made of random masks."""
    rng = np.random.default_rng(1)
    masks = {tile: rng.integers(0, 256, (count, *maps.shape[1:3]), np.uint8) for tile, maps in model.weights.items()}
    slots = len(next(iter(model.parts.values())).differences)
    activations = rng.normal(0, 1, (len(model.expressions), count, slots)).astype(np.float16)
    return replace(model, weights=MaskedWeights(tuple(f"m{k}" for k in range(count)), masks, activations))


def one_part(part, weights, expressions=None, meshes=None, method="refined"):
    """A model of one albedo on one tile."""
    names = expressions or tuple(f"expr_{n}" for n in range(len(weights)))
    return CompressedTextures(method, names, (KNOWN[ALBEDO],), {ALBEDO_KEY: part}, {FIRST_TILE: weights}, meshes)


def part_of(model):
    """The albedo of a model on the first tile."""
    return model.parts[ALBEDO_KEY]


def weights_of(model):
    """Its weight maps ``(N, h, w, R)`` on the first tile."""
    return model.weights[FIRST_TILE]


def rmse(character, model):
    """The mean over expressions of the albedo's RMSE, 0..255."""
    return mean_rmse(albedo_errors(character, model))


@pytest.fixture
def character():
    return random_character()


@pytest.fixture(scope="module")
def surface():
    from tests.facezip.surfaces import random_surface

    return random_surface()


@pytest.fixture
def model():
    return random_model(meshes=True)


def refine(character, differences, weight_scale, importance=None):
    return compress(character, "refined", differences=differences, weight_scale=weight_scale, importance=importance)


def principal_components(character, count):
    return compress(character, "pca", differences=count)


def peak_of_compress(scans, pack, *options):
    """As :func:`tests.peaks.peak_of`, of ``facezip compress`` by PCA."""
    return peak_of(*("compress", scans, "-o", pack, "--overwrite", "--method", "pca", "--differences", 6), *options)
