"""Is the neutral of some scans that of a pack: expressions are differences from it, and mean nothing beside another."""

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.meshes import Meshes
from facezip.character.neutrals import packed_neutral
from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, to_float
from facezip.files.obj import Topology
from facezip.machine.rows import map_rows
from facezip.names import printable
from facezip.pack.belonging import check_sizes
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import StoredTextures

_log = logging.getLogger("facezip")

# RMSE of 255 of a map inside the mask: more than another encoding of an image changes, less than another scan does.
MOST_TEXTURE = 2.0
# How far a vertex may be off, in parts of the largest side of the neutral's bounding box.
MOST_GEOMETRY = 1e-3


def check_same_neutral(character: Character, stored: StoredTextures, model: CompressedTextures, path: Path) -> None:
    """Raise where the scans are not beside the neutral that the pack ``path`` was made from.

    Parameters
    ----------
    character : the scans.
    stored, model : the pack as it is stored, and as a reader sees it.
    path : where it lies, for messages.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``, ``TOPOLOGY_MISMATCH`` for other triangles or another UV layout, ``OTHER_NEUTRAL``.
    """
    check_sizes(character, model, path)
    for key in stored.parts:
        if key not in character.stacks:
            reason = f"has {key[0]} on tile {key[1]}, which {character.name} lacks; give its textures too"
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{path}: {reason}")
        gap = _gap(character, stored.parts[key].neutral, key)
        if gap > MOST_TEXTURE:
            raise _other(character, path, f"{key[0]} differs by {gap:.1f} of 255 inside the mask", MOST_TEXTURE)
    if stored.meshes is not None:
        _check_meshes(character, stored.meshes, path)


def warn_of_another(character: Character, textures: StoredTextures | CompressedTextures, path: Path) -> None:
    """Log where the albedo of a pack's neutral is not that of the scans: what is found may be of another person.

    No error: a pack of cleaned or retouched scans may be compared with the scans before.

    Parameters
    ----------
    character, textures : scans, and the pack ``path``, of the same sizes (:func:`facezip.pack.belonging.check_sizes`).
    """
    keys = [key for key in textures.parts if key[0] == ALBEDO and key in character.stacks]
    gap = max((_gap(character, textures.parts[key].neutral, key) for key in keys), default=0.0)
    if gap > MOST_TEXTURE:
        difference = f"its neutral's albedo differs by {gap:.1f} of 255 from that of {character.name}"
        _log.warning("warning: %s: %s; give the scans that the pack was made from", printable(str(path)), difference)


def _check_meshes(character: Character, theirs: Meshes, path: Path) -> None:
    ours = character.meshes
    if not _same_layout(ours.topology, theirs.topology) or len(ours.neutral) != len(theirs.neutral):
        reason = f"the mesh of {character.name} has other triangles or UVs than its own; give scans on the pack's mesh"
        raise FaceZipError(ErrorCode.TOPOLOGY_MISMATCH, f"{path}: {reason}")
    side = float(np.ptp(theirs.neutral, axis=0).max()) or 1.0
    gap = float(np.abs(ours.neutral - theirs.neutral).max()) / side
    if gap > MOST_GEOMETRY:
        raise _other(character, path, f"mesh is off by {gap:.2%} of the head's size", MOST_GEOMETRY)


def _same_layout(ours: Topology, theirs: Topology) -> bool:
    return np.array_equal(ours.faces, theirs.faces) and np.allclose(
        ours.uv[ours.face_uv], theirs.uv[theirs.face_uv], rtol=0, atol=1e-5
    )


def _gap(character: Character, theirs: Texels, key: Key) -> float:
    stack = character.stacks[key]
    ours, weight = packed_neutral(stack.neutral, character.kind(key[0]), 8 * theirs.itemsize), stack.weight

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        squares = np.square(to_float(ours[top:bottom]) - to_float(theirs[top:bottom])).mean(axis=2)
        return np.array([np.vdot(weight[top:bottom], squares), weight[top:bottom].sum()], np.float64)

    squares, texels = np.sum(map_rows(block, len(ours)), axis=0)
    return float(255 * np.sqrt(squares / max(texels, 1e-30)))


def _other(character: Character, path: Path, difference: str, most: float) -> FaceZipError:
    reason = f"the neutral of {character.name} is not its own: its {difference} (at most {most:g})"
    return FaceZipError(
        ErrorCode.OTHER_NEUTRAL, f"{path}: {reason}; give the new expressions beside the pack's neutral"
    )
