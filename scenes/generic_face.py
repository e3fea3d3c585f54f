"""The generic face that orientation is measured with: the embedded character's, as a few points.

python -m scenes.generic_face facezip/character/face.npz
"""

import sys
from pathlib import Path

import numpy as np

from facezip.character.meshes import Meshes
from facezip.character.surface import Surface
from scenes.character import Person
from scenes.face.expressions import EXPRESSIONS

COUNT = 250
# Of the spread of what moves, about its middle: from cheek to cheek, from the chin to the brows.
HALF_WIDTH, CHIN, BROWS = 0.85, -1.0, 1.25


def generic_face() -> Surface:
    """``COUNT`` points of the face, seen from the front, about the middle of what moves and of its spread."""
    person = Person.make(64)
    posed = np.stack([person.vertices(weights) for weights in EXPRESSIONS.values()])
    head = Surface.of(Meshes(person.head.topology, person.head.vertices, posed), 12000, seed=1)
    if head is None:
        raise RuntimeError("the embedded character does not move")
    seen = head.seen()
    x, y, _ = seen.points.T
    face = (np.abs(x) < HALF_WIDTH) & (y > CHIN) & (y < BROWS) & (seen.normals[:, 2] > 0)
    return seen.only(np.flatnonzero(face)[:COUNT])


if __name__ == "__main__":
    made = generic_face()
    np.savez_compressed(Path(sys.argv[1]), **{name: part.astype(np.float32) for name, part in vars(made).items()})
