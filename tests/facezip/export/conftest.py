import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from facezip import write_pack
from facezip.model import CompressedTextures
from tests.facezip.conftest import random_model

NODE = Path(__file__).parents[2] / "node"


@pytest.fixture(scope="session")
def node():
    """Runs one of the scripts of ``tests/node`` and reads the JSON that it prints."""
    if shutil.which("node") is None:
        pytest.skip("Node.js is not installed")
    if not (NODE / "node_modules").is_dir():
        pytest.skip("its packages are not installed: npm ci --prefix tests/node")

    def run(script, *arguments):
        command = ["node", str(NODE / script), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture
def encoder(node, monkeypatch):
    """The UASTC encoder can be found."""
    monkeypatch.setenv("NODE_PATH", str(NODE / "node_modules"))
    return os.environ


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
