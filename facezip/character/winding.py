"""Which way the triangles of a mesh face: engines do not draw those that face away, and light them from behind."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from facezip.character.notes import Note
from facezip.character.scans import Character

# Of triangles, by area and distance: heads and masks of faces have 0.88 to 0.99 outwards, or as many inwards.
CLEARLY = 0.5


def notes_on_winding(character: Character) -> Iterator[Note]:
    """A note where the neutral is inside out: mirrored, or with its faces reversed."""
    if outwards(character.meshes.neutral, character.meshes.topology.faces) < -CLEARLY:
        words = "its triangles face inwards; reverse its faces, or mirror it back where it is mirrored"
        yield Note(character.name, words, asks=True)


def outwards(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> float:
    """How far triangles face away from the middle of their surface: 1 where all do, -1 where none does, 0 of a plane.

    Parameters
    ----------
    vertices : ``(V, 3)``.
    faces : ``(F, 3)``.
    """
    corners = vertices.astype(np.float64)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    places, areas = corners.mean(axis=1), np.linalg.norm(normals, axis=1)
    if not areas.any():
        return 0.0
    volumes = np.einsum("fc,fc->f", normals, places - np.average(places, axis=0, weights=areas))
    whole = np.abs(volumes).sum()
    # Of a plane there is nothing but rounding.
    return float(volumes.sum() / whole) if whole > 1e-6 * areas.sum() ** 1.5 else 0.0
