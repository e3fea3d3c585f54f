"""How wrong the sum of two shapes is, on the embedded character, where the truth of every pair is known.

python -m tests.facezip.rigging.pairs [SEED [RESOLUTION]]

Textures blend linearly, skin does not. Of all pairs out of the shapes that change the skin most (one of each left and
right, and both mouth corners) the true texture is compared with the neutral plus both changes, and with that plus K
correctives that are driven by products of weights: the K pairs of the largest error, each with a map of its own; and,
as the least that any K maps could leave, the K principal components of all pairs' errors.
"""

import sys
from itertools import combinations

import numpy as np

from scenes.character import Person, face_mask

SHAPES = (
    "browDownLeft", "browInnerUp", "browOuterUpLeft", "cheekPuff", "cheekSquintLeft", "eyeSquintLeft", "jawOpen",
    "mouthFrownLeft", "mouthFunnel", "mouthPucker", "mouthSmileLeft", "mouthSmileRight", "mouthStretchLeft",
    "noseSneerLeft",
)  # fmt: skip
COUNTS = (1, 2, 4, 8, 16)


def changes(person: Person, mask: np.ndarray, *names: str) -> np.ndarray:
    """``(K, 3)`` on the face: what shapes together change."""
    texture = person.texture(dict.fromkeys(names, 1.0))
    return (texture - person.albedo)[mask]


def rmse(errors: np.ndarray) -> float:
    """The mean over pairs of the error, 0..255."""
    return float(255 * np.sqrt(np.square(errors).mean(axis=1)).mean())


if __name__ == "__main__":
    seed, resolution = (int(given) for given in [*sys.argv[1:], *("0", "256")[len(sys.argv) - 1 :]])
    one = Person.make(resolution, seed)
    face = face_mask(one.head, resolution) > 0
    single = {name: changes(one, face, name) for name in SHAPES}
    pairs = list(combinations(SHAPES, 2))
    true = np.stack([changes(one, face, *pair).ravel() for pair in pairs])
    sums = np.stack([(single[a] + single[b]).ravel() for a, b in pairs])
    gaps = true - sums
    print(f"{len(pairs)} pairs: changes {rmse(true):.3f}, error of the sum {rmse(gaps):.3f}")
    size = np.square(gaps).sum(axis=1)
    order = np.argsort(-size)
    for n in order[:5]:
        print(f"  {' + '.join(pairs[n]):34} changes {rmse(true[n : n + 1]):.2f}, error {rmse(gaps[n : n + 1]):.2f}")
    values, vectors = np.linalg.eigh(gaps @ gaps.T)
    for count in COUNTS:
        left = gaps.copy()
        left[order[:count]] = 0
        basis = vectors[:, -count:]
        least = gaps - basis @ (basis.T @ gaps)
        print(f"  {count:2} correctives leave {rmse(left):.3f}, principal components {rmse(least):.3f}")
