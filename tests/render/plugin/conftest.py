import numpy as np
import pytest

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
