"""Is every expression the neutral's head, of its size and in its place; what certainly is not is brought there.

Exporters write one mesh in another unit, as offsets from the neutral, in another corner of the scene or along other
axes. A captured head moves too: docs/meshes.md has how much, and that is left as it is.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.character.motion import Motion, Points, angle_between, motion_between, nearest_axes, spread_of
from facezip.character.notes import Note
from facezip.errors import ErrorCode, FaceZipError

# Between these an expression is as large as the neutral.
LEAST, MOST = 0.8, 1.25
# Ratios of units: powers of ten, inches and feet in metric ones, and how well a mesh has to agree with one.
UNITS = sorted({one * 10.0**power for one in (1.0, 2.54, 3.048, 1 / 2.54, 1 / 3.048, 1.2) for power in range(-6, 7)})
AGREEMENT = 1.06
# A head turns by less degrees (three quarters of what it can), and moves by less of its largest extent.
TURNED, AWAY = 60.0, 0.5
# Exporters turn by right angles: so near in degrees.
RIGHT_ANGLE = 15.0
# Root mean square of what an expression moves, of the head's spread: beyond it is no expression of this head.
UNLIKE = 0.4
# Offsets have a smaller spread than this beside the head's.
SMALL = 0.35
# Vertices that tell how a mesh stands.
ENOUGH = 3000
# So many sizes away it is moved to the origin.
FAR = 100.0


def brought_to_neutral(meshes: Meshes, names: tuple[str, ...], path: Path) -> tuple[Meshes, list[Note]]:
    """Meshes in which every expression is a form of the neutral, and what was done to which.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: a mesh is not of the neutral's size or shape and it is not certain why.
    """
    used = np.flatnonzero(np.bincount(meshes.topology.faces.ravel()))
    used = used[:: max(len(used) // ENOUGH, 1)]
    neutral = meshes.neutral[used].astype(np.float64)
    size = float(np.ptp(neutral, axis=0).max())
    notes: list[Note] = []
    if size == 0:
        return meshes, notes
    origin = _origin(neutral, size)
    vertices = meshes.vertices
    for n, name in enumerate(names):
        found = _brought(neutral, meshes.neutral, vertices[n], used, f"{path}: mesh '{name}'")
        if found is not None:
            vertices = vertices.copy() if vertices is meshes.vertices else vertices
            vertices[n], words = found
            notes.append(Note(name, f"its mesh {words}"))
    if origin is not None:
        notes.append(Note("neutral", f"the head lies {np.linalg.norm(origin) / size:.0f} times its size away; moved"))
        meshes = replace(meshes, neutral=_moved(meshes.neutral, -origin))
        vertices = _moved(vertices, -origin)
    return (replace(meshes, vertices=vertices) if notes else meshes), notes


def _moved(vertices: NDArray[np.float32], shift: Points) -> NDArray[np.float32]:
    return (vertices + shift).astype(np.float32)


def _origin(neutral: Points, size: float) -> Points | None:
    """What a head is moved by that lies far away; None for one that does not."""
    middle: Points = (neutral.min(axis=0) + neutral.max(axis=0)) / 2
    return middle if np.abs(middle).max() > FAR * size else None


def _brought(
    neutral: Points,
    all_neutral: NDArray[np.float32],
    vertices: NDArray[np.floating],
    used: NDArray[np.integer],
    what: str,
) -> tuple[NDArray[np.floating], str] | None:
    """An expression's vertices as they should be, and in words why; None where they are."""
    done: list[str] = []
    some = vertices[used].astype(np.float64)
    motion = motion_between(neutral, some)
    if motion.rest > UNLIKE and spread_of(some) < SMALL * spread_of(neutral):
        added = all_neutral + vertices.astype(np.float64)
        if motion_between(neutral, added[used]).rest < UNLIKE:
            vertices, motion = added, motion_between(neutral, added[used])
            done.append("holds offsets from the neutral; added to it")
    if motion.rest > UNLIKE:
        raise _unlike(neutral, some, what)
    if not LEAST < motion.scale < MOST:
        factor = min(UNITS, key=lambda unit: abs(np.log(unit / motion.scale)))
        if not 1 / AGREEMENT < factor / motion.scale < AGREEMENT:
            raise _sized(motion, what)
        vertices = vertices.astype(np.float64) / factor
        done.append(f"is {_times(motion.scale)} as large as the neutral; brought to its size")
    if np.linalg.det(motion.turn) < 0 or motion.degrees > TURNED:
        axes = nearest_axes(motion.turn)
        exact = angle_between(axes, motion.turn) < RIGHT_ANGLE
        vertices = vertices @ (axes if exact else motion.turn)
        how = "is mirrored" if np.linalg.det(motion.turn) < 0 else f"is turned by {motion.degrees:.0f} degrees"
        done.append(f"{how} against the neutral; turned back")
    away = np.median(vertices[used] - neutral, axis=0)
    far = float(np.linalg.norm(away) / np.ptp(neutral, axis=0).max())
    if far > AWAY:
        vertices = vertices - away
        done.append(f"lies {far:.2g} head sizes away from the neutral; moved onto it")
    return (vertices, ", ".join(done)) if done else None


def _times(scale: float) -> str:
    return f"{scale:.3g} times"


def _sized(motion: Motion, what: str) -> FaceZipError:
    reason = f"is {_times(motion.scale)} as large as the neutral, which is no ratio of units"
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{what} {reason}; export both in one unit")


def _unlike(neutral: Points, moved: Points, what: str) -> FaceZipError:
    sizes = " and ".join(f"{np.ptp(points, axis=0).max():.3g}" for points in (moved, neutral))
    reason = "is no form of the neutral's, wherever it is placed and however large"
    return FaceZipError(
        ErrorCode.BAD_CHARACTER, f"{what} {reason}: their sizes are {sizes}; export it with the neutral's vertices"
    )
