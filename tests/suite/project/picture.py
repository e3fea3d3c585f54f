"""An 8-bit picture with the noise of a sensor; a test a trial, each with a subject of its own."""

import os

import numpy as np
import pytest

DEFECT = os.environ.get("DEFECT", "")


def photograph(trial, seed):
    y, x = np.mgrid[:48, :64] / 48
    tones = np.random.default_rng(trial).uniform(0.2, 0.8, (3, 3))
    light = tones[0] + np.sin(9 * x)[..., None] * tones[1] / 4 + np.cos(7 * y)[..., None] * tones[2] / 4
    light = np.clip(light, 0, 1) + np.random.default_rng([trial, seed]).normal(0, 0.02, light.shape)
    if DEFECT == "a patch of 16 pixels two codes brighter":
        light[16:32, 24:40] += 2 / 255
    if DEFECT == "one pixel to the right":
        light = np.roll(light, 1, axis=1)
    return np.round(255 * np.clip(light, 0, 1)).astype(np.uint8)


@pytest.mark.parametrize("trial", range(int(os.environ["TRIALS"])))
def test_photograph(facezip_image, trial):
    facezip_image(lambda seed: photograph(trial, seed))
