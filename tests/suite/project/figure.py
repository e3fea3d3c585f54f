"""A figure of matplotlib, which has no noise; a test a trial, each with data of its own."""

import os

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

DEFECT = os.environ.get("DEFECT", "")


def draw(trial):
    rng = np.random.default_rng(trial)
    figure, axes = plt.subplots(figsize=(3.2, 2.4), dpi=30)
    axes.plot(rng.random(12).cumsum(), linewidth=1.7 if DEFECT == "line wider by 0.2 points" else 1.5)
    axes.plot(rng.random(12).cumsum(), color="C3")
    axes.set_xticks([0, 6], ["0", "5" if DEFECT == "another digit at an axis" else "6"])
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()
    plt.close(figure)
    return picture


@pytest.mark.parametrize("trial", range(int(os.environ["TRIALS"])))
def test_curves(facezip_image, trial):
    facezip_image([draw(trial)] * 8)
