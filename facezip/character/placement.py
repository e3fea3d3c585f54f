"""How a character's meshes stand: upright and looking at +z, every expression where the neutral is and of its size.

What ``character.toml`` says of axes and unit is done as it says. Otherwise the geometry is looked at: what leaves no
doubt is put right, with a note; what cannot be right is refused.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.likeness import brought_to_neutral
from facezip.character.meshes import Meshes
from facezip.character.motion import Points, angle_between, nearest_axes
from facezip.character.notes import Note
from facezip.character.orientation import Orientation, orientation_of
from facezip.character.scans import NEUTRAL
from facezip.character.units import UNITS
from facezip.errors import ErrorCode, FaceZipError

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}
# What a head has to show before it is turned, and how near it has to be to axes (degrees); docs/meshes.md has what
# heads do show.
FACING, SYMMETRIC, UPRIGHT, OFF, NEAR_AXES = 0.3, 1.15, 1.1, 0.19, 30.0
# A head that is turned by more than this is not one that holds its head askew.
ASKEW = 55.0
# Extents of a head, of a mask or a bust, in centimetres.
LEAST, MOST = 5.0, 200.0


@dataclass(frozen=True)
class Placement:
    """What ``character.toml`` says of all meshes; None for what it does not say.

    Attributes
    ----------
    up, front : keys of :data:`AXES`, at right angles: where the crown is, and where the face looks.
    unit : a key of :data:`facezip.character.units.UNITS`; meshes are then brought to centimetres.
    """

    up: str | None = None
    front: str | None = None
    unit: str | None = None

    @staticmethod
    def of(entries: Mapping[str, Any]) -> "Placement":
        """From the entries of these names; ``ValueError`` for what they may not say."""
        for name, known in (("up", AXES), ("front", AXES), ("unit", UNITS)):
            if name in entries and (not isinstance(entries[name], str) or entries[name] not in known):
                raise ValueError(f"{name} is one of {', '.join(known)}")
        stated = Placement(**entries)
        up, front = (stated.up or "y"), (stated.front or "z")
        if up[-1] == front[-1]:
            raise ValueError(f"up is {up} and front is {front}, which is one line; say both, at right angles")
        return stated

    @property
    def axes(self) -> Points | None:
        """``(3, 3)``, one a row: to the character's left, up, ahead; None where neither is said."""
        if self.up is None and self.front is None:
            return None
        up, front = np.array(AXES[self.up or "y"], float), np.array(AXES[self.front or "z"], float)
        return np.stack([np.cross(up, front), up, front])


def placed(
    meshes: Meshes, expressions: tuple[str, ...], stated: Placement, path: Path
) -> tuple[Meshes, tuple[Note, ...]]:
    """Meshes as they should stand, and what was done to them.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: a mesh has another size, shape or place than the neutral's, a head looks elsewhere and it is
        not certain how it has to be turned, or is not of the size that the stated unit makes it.
    """
    meshes, notes = brought_to_neutral(meshes, expressions, path)
    if stated.unit is not None:
        meshes = _in_centimetres(meshes, stated.unit, path)
        if stated.unit != "cm":
            notes.append(Note(NEUTRAL, f"the head and its expressions are in {stated.unit}; brought to cm"))
    axes = stated.axes
    if axes is None:
        axes, found = _found(meshes, path)
        notes += found
    elif not np.array_equal(axes, np.eye(3)):
        notes.append(Note(NEUTRAL, f"{_turn_words(axes)}, as character.toml says"))
    if not np.array_equal(axes, np.eye(3)):
        meshes = _changed(meshes, axes.T)
    return meshes, tuple(notes)


def _in_centimetres(meshes: Meshes, unit: str, path: Path) -> Meshes:
    made = replace(_changed(meshes, UNITS[unit] * np.eye(3)), centimetres=True)
    size = float(np.ptp(made.neutral, axis=0).max())
    if not LEAST <= size <= MOST:
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{path}: in {unit}, as character.toml says, the neutral is {size:.3g} cm large; say another unit",
        )
    return made


def _found(meshes: Meshes, path: Path) -> tuple[Points, list[Note]]:
    """The axes of a head that looks elsewhere, and what to say of them; of any other mesh the usual ones."""
    usual: Points = np.eye(3)
    head = orientation_of(meshes)
    if head is None or head.facing < FACING or head.symmetric < SYMMETRIC or head.off > OFF:
        return usual, []
    axes = nearest_axes(head.axes)
    near = angle_between(axes, head.axes) <= NEAR_AXES
    if np.array_equal(axes, usual) or (not near and angle_between(usual, head.axes) < ASKEW):
        return usual, []
    if near and head.upright >= UPRIGHT:
        return axes, [Note(NEUTRAL, _turn_words(axes))]
    if axes[2, 2] > 0 and near:
        return usual, [Note(NEUTRAL, f"the head may be {_askew(axes)}; {_remedy(axes)} if it is", asks=True)]
    if head.off_usual < UPRIGHT * head.off:
        return usual, []
    raise _doubt(head, axes, path)


def _doubt(head: Orientation, axes: Points, path: Path) -> FaceZipError:
    ahead = ", ".join(f"{part:.1f}" for part in head.axes[2])
    return FaceZipError(
        ErrorCode.BAD_CHARACTER,
        f"{path}: the face of the neutral seems to look along ({ahead}), not along z with y up, and how it has to be "
        f"turned is not certain; {_remedy(axes)} (docs/meshes.md)",
    )


def _askew(axes: Points) -> str:
    return "upside down" if axes[1, 1] < 0 else "on its side"


def _remedy(axes: Points) -> str:
    return f'say such as up = "{_name(axes[1])}" and front = "{_name(axes[2])}" in character.toml'


def _turn_words(axes: Points) -> str:
    return f"the head looks along {_name(axes[2])} with {_name(axes[1])} up; turned to look along z with y up"


def _name(axis: Points) -> str:
    return next(name for name, known in AXES.items() if np.allclose(axis, known))


def _changed(meshes: Meshes, matrix: Points) -> Meshes:
    def changed(vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        return (vertices.astype(np.float64) @ matrix).astype(np.float32)

    return replace(meshes, neutral=changed(meshes.neutral), vertices=changed(meshes.vertices))
