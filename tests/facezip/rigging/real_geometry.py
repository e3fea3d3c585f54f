"""Rigging on production geometry, with figures.

python -m tests.facezip.rigging.real_geometry ../shared/data/ict_facekit/ict_face.npz
"""

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from facezip.rigging.fit import fit_rig
from facezip.rigging.weightmaps import Examples
from scenes.template import another_identity

SCANS, SEED = 20, 0


def triangles(faces):
    """Quads as two triangles; triangles are padded with -1."""
    quads = faces[faces[:, 3] >= 0]
    return np.concatenate([faces[:, :3], quads[:, [0, 2, 3]]]).astype(np.int32)


def mixtures(count, shapes, seed=SEED):
    """Scans as random combinations of four to eight shapes."""
    rng = np.random.default_rng(seed)
    weights = np.zeros((count, shapes))
    for row in weights:
        chosen = rng.choice(shapes, rng.integers(4, 9), replace=False)
        row[chosen] = rng.uniform(0.3, 1.0, len(chosen))
    return weights


def rig_from(file: Path):
    """The rig of a character made of ``file``'s shapes from a distorted identity; true deltas, weights, seconds."""
    data = np.load(file)
    neutral = data["neutral"].astype(np.float32)
    deltas = (data["vertices"] - data["neutral"]).astype(np.float32)
    weights = mixtures(SCANS, len(deltas))
    scans = np.tensordot(weights, deltas, 1).astype(np.float32)
    begin = perf_counter()
    rig = fit_rig(neutral, scans, triangles(data["faces"]), *another_identity(neutral, deltas, 1))
    return rig, deltas, weights, perf_counter() - begin


def error(found, true):
    """Mean vertex error over mean displacement."""
    return float(np.linalg.norm(found - true, axis=2).mean() / np.linalg.norm(true, axis=2).mean())


if __name__ == "__main__":
    result, true, mixed, seconds = rig_from(Path(sys.argv[1]))
    seen = mixed.max(axis=0) > 0
    for name, found in (("transferred", result.transferred), ("generated", result.deltas)):
        parts = error(found, true), error(found[seen], true[seen]), error(found[~seen], true[~seen])
        print(f"{name:12} {parts[0]:.3f} of the mean displacement; seen {parts[1]:.3f}, unseen {parts[2]:.3f}")
    print(f"weights off by {np.abs(result.weights - mixed).mean():.3f} in the mean; {seconds:.1f} s")
    print(f"cond(B) {Examples.of(result.weights).condition:.1f}; left of scans {result.residuals.mean():.4f}")
