import numpy as np
import pytest

from facezip import write_pack
from facezip.model import CompressedTextures
from tests.facezip.conftest import random_model


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


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(smooth_model(), path)
    return path
