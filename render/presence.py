"""Is there a face in a picture: an average over nothing, or over black, would be a calm verdict on the wrong thing."""

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.character.tiles import place_of, tiles_of_faces
from facezip.errors import ErrorCode, FaceZipError


def face_triangles(character: Character) -> NDArray[np.bool_]:
    """``(F,)``: which triangles the mask shows, at a corner or in the middle; all of a tile without a mask."""
    topology, tiles = character.meshes.topology, character.tiles
    corners = topology.uv[topology.face_uv].astype(np.float64)
    middle = corners.mean(axis=1, keepdims=True)
    # Within the triangle: corners on the border of a tile are of two.
    points = np.concatenate([middle, middle + 0.99 * (corners - middle)], axis=1)
    on_face, place = np.zeros(len(corners), bool), tiles_of_faces(topology, tiles)
    for index, tile in enumerate(tiles):
        here, mask = place == index, character.stacks[ALBEDO, tile].mask
        if mask is None:
            on_face |= here
            continue
        x, y = np.moveaxis(points[here] - place_of(tile), 2, 0)
        rows, columns = (
            np.clip(at * size, 0, size - 1).astype(int) for at, size in zip((1 - y, x), mask.shape, strict=True)
        )
        on_face[here] = (mask[rows, columns] > 0).any(axis=1)
    return on_face


def check_present(
    linear: NDArray[np.float32], triangles: NDArray[np.int32], face: NDArray[np.bool_], where: str
) -> None:
    """Raise ``NOTHING_TO_SEE`` for a render that shows no face, or nothing of it.

    Parameters
    ----------
    linear : ``(H, W, 3)`` radiance.
    triangles : ``(H, W)``, the triangle under every pixel, -1 beside the head.
    face : ``(F,)``, of :func:`face_triangles`.
    where : what the picture is of, for the message.
    """
    seen = (triangles >= 0) & face[np.maximum(triangles, 0)]
    if not seen.any():
        what = "the face" if (triangles >= 0).any() else "the head"
        raise _absent(f"{where}: {what} covers no pixel; turn the head by up and front in character.toml, or the view")
    if not np.isfinite(linear).all():
        raise _absent(f"{where}: the picture holds values that are no numbers; repair the mesh and its textures")
    if not linear[seen].max() > 0:
        raise _absent(f"{where}: the face is black in the picture; look at its textures and its mesh")


def _absent(message: str) -> FaceZipError:
    return FaceZipError(ErrorCode.NOTHING_TO_SEE, message)
