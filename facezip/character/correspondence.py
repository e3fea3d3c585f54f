"""Whether a mesh is the neutral's, however it was written, and its vertices in the neutral's order.

Exporters begin triangles at another corner, reorder them, cut quads along the other diagonal, copy vertices at seams,
and write UVs in lists of their own with fewer digits. All of that is one mesh. Corners of one are paired with corners
of the other by the numbers of their vertices or, where these differ, by their UVs; what is in doubt is refused.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from facezip.character.pairing import Indices, Pairs, describe_difference, pair_corners, row_numbers
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology

# Where the size of the textures is not known: a sixteenth of a texel of 6,250, and twice the rounding of five decimals.
UV_TOLERANCE = 1e-5
# Copies of one vertex are the same but for their last digits: how far apart they may be, as a part of the mesh's size.
COPIES_APART = 1e-5
# Triangles around a vertex, at most, where meshes are compared by UVs that each of them rounds by itself.
AROUND = 12


def in_order_of(
    path: Path,
    neutral: NDArray[np.float32],
    topology: Topology,
    vertices: NDArray[np.float32],
    other: Topology,
    tolerance: float = UV_TOLERANCE,
) -> NDArray[np.float32]:
    """The vertices of a mesh in the order of the neutral's, if it is the same mesh with the same UV layout.

    Parameters
    ----------
    path : the mesh's file, for messages.
    neutral, topology : ``(V, 3)`` vertices of the neutral, and its triangles.
    vertices, other : ``(V', 3)`` vertices of the mesh, and its triangles.
    tolerance : how far apart UVs may be; a small part of a texel.

    Returns
    -------
    ``(V, 3)`` float32. A vertex that no triangle uses stays the neutral's where the other mesh has no such vertex.

    Raises
    ------
    FaceZipError
        ``TOPOLOGY_MISMATCH``: other triangles, another UV layout, or vertices whose correspondence is in doubt.
    """
    if len(vertices) == len(neutral) and _alike(topology, other, tolerance):
        return vertices
    try:
        pairs, by_number = _pair(topology, other, tolerance)
        _check_uvs(pairs, topology, other, tolerance)
        if by_number and len(vertices) == len(neutral):
            return vertices
        return _gather(pairs, neutral, topology, vertices, other)
    except _Difference as difference:
        counts = (len(vertices), len(neutral))
        beside = f"{counts[0]} vertices, the neutral has {counts[1]}; " if counts[0] != counts[1] else ""
        raise FaceZipError(ErrorCode.TOPOLOGY_MISMATCH, f"{path}: {beside}{difference}") from None


def _alike(topology: Topology, other: Topology, tolerance: float) -> bool:
    """Whether the lists are the same, as of almost all characters: no corner needs to be looked at."""
    return (
        np.array_equal(topology.faces, other.faces)
        and np.array_equal(topology.face_uv, other.face_uv)
        and topology.uv.shape == other.uv.shape
        and bool((np.abs(topology.uv - other.uv) <= tolerance).all())
    )


class _Difference(ValueError):
    """In what the meshes differ, where, and what to do."""


def _pair(topology: Topology, other: Topology, tolerance: float) -> tuple[Pairs, bool]:
    """Pairs of corners, and whether vertices of the same number correspond."""
    by_number = pair_corners(topology.faces, other.faces)
    # Numbers say nothing where no two triangles share one.
    if by_number is not None and np.bincount(topology.faces.ravel()).max() > 1:
        return by_number, True
    if len(topology.faces) == len(other.faces):
        along = np.arange(topology.faces.size)
        if not _apart(Pairs(along, along), topology, other, tolerance).any():
            return Pairs(along, along), by_number is not None
    numbers = _numbers_of_uvs(topology, other, tolerance)
    by_uv = None if numbers is None else pair_corners(*numbers)
    if by_uv is not None:
        return by_uv, False
    if by_number is not None:
        return by_number, True
    raise _Difference(describe_difference(*(numbers or (topology.faces, other.faces))))


def _apart(pairs: Pairs, topology: Topology, other: Topology, tolerance: float) -> NDArray[np.bool_]:
    """Which pairs of corners ``(P,)`` have other UVs."""
    mine, theirs = topology.face_uv.ravel()[pairs.mine], other.face_uv.ravel()[pairs.theirs]
    return (np.abs(topology.uv[mine] - other.uv[theirs]) > tolerance).any(axis=1)


def _check_uvs(pairs: Pairs, topology: Topology, other: Topology, tolerance: float) -> None:
    apart = _apart(pairs, topology, other, tolerance)
    if not apart.any():
        return
    mine, theirs = int(pairs.mine[apart.argmax()]), int(pairs.theirs[apart.argmax()])
    seen, meant = other.uv[other.face_uv.ravel()[theirs]].tolist(), topology.uv[topology.face_uv.ravel()[mine]].tolist()
    raise _Difference(
        f"another UV layout than neutral.obj at {apart.mean():.0%} of the corners, first in its triangle "
        f"{theirs // 3 + 1}: ({seen[0]:.6g}, {seen[1]:.6g}) instead of ({meant[0]:.6g}, {meant[1]:.6g}); transfer the "
        "neutral's UVs"
    )


def _gather(
    pairs: Pairs, neutral: NDArray[np.float32], topology: Topology, vertices: NDArray[np.float32], other: Topology
) -> NDArray[np.float32]:
    """The neutral's vertices at the places of those of the other mesh; ``_Difference`` where copies are apart."""
    mine, theirs = topology.faces.ravel()[pairs.mine], other.faces.ravel()[pairs.theirs]
    ordered = neutral.copy()
    ordered[mine] = vertices[theirs]
    gaps = np.abs(ordered[mine] - vertices[theirs]).max(axis=1)
    if gaps.max() > COPIES_APART * np.ptp(vertices[theirs], axis=0).max():
        raise _Difference(
            f"vertex {mine[gaps.argmax()] + 1} of the neutral is at places that lie {gaps.max():.3g} apart; fit the "
            "neutral's topology to the scan"
        )
    return ordered


def _numbers_of_uvs(topology: Topology, other: Topology, tolerance: float) -> tuple[Indices, Indices] | None:
    """Numbers ``(F, 3)`` of the neutral's UVs at the corners of both meshes; None where UVs leave a doubt."""
    used, at_corner = np.unique(topology.face_uv, return_inverse=True)
    points, point = np.unique(topology.uv[used], axis=0, return_inverse=True)
    tree = cKDTree(points)
    # Lists that are not shared may hold a point for every triangle around it, with other last digits.
    gaps, nearest = map(np.asarray, tree.query(points, k=AROUND, p=np.inf, distance_upper_bound=2 * tolerance))
    close, neighbour = np.nonzero(gaps <= tolerance)
    links = coo_array((np.ones(len(close)), (close, nearest[close, neighbour])), shape=(len(points), len(points)))
    number = connected_components(links, directed=False)[1].astype(np.intp)
    mine = number[point.ravel()[at_corner.reshape(-1, 3)]]
    sets = np.sort(mine, axis=1)
    gap, nearest = map(np.asarray, tree.query(other.uv, p=np.inf, distance_upper_bound=2 * tolerance))
    if (
        (sets[:, 0] == sets[:, 2]).any()
        or row_numbers(sets).max() + 1 < len(sets)
        or (gap[other.face_uv] > tolerance).any()
    ):
        return None
    return mine, number[nearest[other.face_uv]]
