import json

import numpy as np
import pytest

from facezip.files.documents import read_document
from render.plugin.results import ImagesDocument
from tests.documents.checked import check

SIDE = 32


def scene_mean():
    """A bright disc with soft shading on black: noise inside, a hard edge, and certain pixels around it."""
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    disc = (np.hypot(x, y) < 12)[..., None]
    return disc * (0.4 + 0.01 * x[..., None] + np.array([0.1, 0.0, -0.1]))


def noisy(seed, gain=1.0, fireflies=True):
    """A render of it: noise that grows with the light, flickering edge pixels, rare fireflies."""
    rng = np.random.default_rng(seed)
    mean = scene_mean()
    image = mean * gain * rng.gamma(60, 1 / 60, mean.shape[:2])[..., None]
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    edge = np.abs(np.hypot(x, y) - 12.2) < 0.6
    image[edge] += 0.3 * (rng.random(edge.sum()) < 0.02)[:, None]
    if fireflies:
        hit = rng.random(mean.shape[:2]) < 2e-4
        image[hit & (mean[..., 0] > 0)] += rng.exponential(2.0)
    return image.astype(np.float32)


def renders(seeds, **settings):
    return np.stack([noisy(seed, **settings) for seed in seeds])


@pytest.fixture(scope="session")
def reference():
    from render.plugin.reference import Reference

    return Reference.of(renders(range(32)))


def images_in(folder):
    """What a run left in its results, as published."""
    path = folder / "results.json"
    assert check(json.loads(path.read_bytes())) == "images"
    return read_document(path, ImagesDocument)


HEAD = """
import numpy as np
import pytest

def render(seed, gain=1.0):
    rng = np.random.default_rng(seed)
    image = np.zeros((24, 32, 3), np.float32)
    image[4:20, 4:28] = gain * rng.gamma(100, 0.004, (16, 24, 1))
    return image
"""
EQUAL = "def test_box(facezip_image):\n    facezip_image(render)\n"
BRIGHTER = "def test_box(facezip_image):\n    facezip_image(lambda seed: render(seed, 1.03))\n"
STEM = "test_it.test_box"


@pytest.fixture
def project(pytester):
    """A foreign repository; returns a function that runs a test file in it, in this process."""

    def run(body, *arguments):
        pytester.makepyfile(test_it=HEAD + body)
        return pytester.runpytest("-p", "no:cacheprovider", *arguments)

    return run


@pytest.fixture
def generated(project, pytester):
    """The same, with the reference of ``EQUAL`` in ``baseline``."""
    project(EQUAL, "--facezip-generate", "baseline").assert_outcomes(skipped=1)
    assert [path.name for path in (pytester.path / "baseline").iterdir()] == [f"{STEM}.exr"]
    return project
