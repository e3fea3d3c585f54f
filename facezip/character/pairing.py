"""Which corners of two lists of triangles are the same, however these are ordered, begun and cut out of polygons."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Numbers = NDArray[np.integer]
Indices = NDArray[np.intp]


class Pairs(NamedTuple):
    """``(P,)`` corners, counted along the triangles, of which those at the same place correspond; each occurs."""

    mine: Indices
    theirs: Indices


class Difference(ValueError):
    """In what two meshes differ, and where."""


def pair_corners(mine: Numbers, theirs: Numbers) -> Pairs:
    """Pair the corners of the same triangles, and of the same polygons where their triangles are others.

    Triangles are the same where their corners follow each other in the same order, polygons where their outlines do.

    Parameters
    ----------
    mine, theirs : ``(F, 3)`` and ``(F', 3)``, what lies at the corners of triangles: numbers of vertices, or of UVs.

    Raises
    ------
    Difference
        There is a triangle that the other list does not have, alone or as a part of a polygon.
    """
    if np.array_equal(mine, theirs):
        return Pairs(np.arange(mine.size), np.arange(mine.size))
    orders, their_orders = _least_first(mine), _least_first(theirs)
    turned = np.concatenate([np.take_along_axis(mine, orders, 1), np.take_along_axis(theirs, their_orders, 1)])
    key, their_key = np.split(np.unique(turned, axis=0, return_inverse=True)[1].ravel(), [len(mine)])
    bins = 1 + max(key.max(initial=0), their_key.max(initial=0))
    shared = np.bincount(key, minlength=bins) == np.bincount(their_key, minlength=bins)
    rows, their_rows = _by_key(key, shared), _by_key(their_key, shared)
    pairs = [Pairs(_corners(rows, orders[rows]), _corners(their_rows, their_orders[their_rows]))]
    left, their_left = np.flatnonzero(~shared[key]), np.flatnonzero(~shared[their_key])
    if len(left) or len(their_left):
        pairs += _pair_polygons(mine, theirs, left, their_left)
    return Pairs(*(np.concatenate(each) for each in zip(*pairs, strict=True)))


def _least_first(triangles: Numbers) -> Indices:
    """The order ``(F, 3)`` in which each triangle's corners begin with the least number, and its first copy."""
    rows, first, least = np.arange(len(triangles)), triangles.argmin(axis=1), triangles.min(axis=1)
    first = np.where(triangles[rows, first - 1] == least, first - 1, first)
    return (first[:, None] + np.arange(3)) % 3


def _by_key(key: Indices, shared: NDArray[np.bool_]) -> Indices:
    """The triangles whose key is shared, in the order of their keys and then of the file."""
    rows = np.flatnonzero(shared[key])
    return rows[np.argsort(key[rows], kind="stable")]


def _corners(rows: Indices, order: Indices) -> Indices:
    return (3 * rows[:, None] + order).ravel()


def _pair_polygons(mine: Numbers, theirs: Numbers, left: Indices, their_left: Indices) -> list[Pairs]:
    """Pair what is left over: triangles that meet at edges which the other list does not have are one polygon."""
    difference = _difference(mine, theirs, left, their_left)
    if not (len(left) and len(their_left)):
        raise difference
    edges = np.concatenate([_edges(mine[left]), _edges(theirs[their_left])]).reshape(-1, 2)
    directed, undirected = (
        np.split(np.unique(some, axis=0, return_inverse=True)[1].reshape(-1, 3), [len(left)])
        for some in (edges, np.sort(edges, axis=1))
    )
    outline = np.isin(undirected[0], undirected[1])
    their_outline = np.isin(undirected[1], undirected[0])
    polygon, sides = _join(undirected[0], directed[0], outline, difference)
    their_polygon, their_sides = _join(undirected[1], directed[1], their_outline, difference)
    if not np.array_equal(sides[0], their_sides[0]):
        raise difference
    same = np.unique(np.stack([sides[1], their_sides[1]]), axis=1)
    if not (same.shape[1] == polygon.max() + 1 == their_polygon.max() + 1):
        raise difference
    as_mine = np.empty(same.shape[1], np.intp)
    as_mine[same[1]] = same[0]
    most = 1 + max(mine.max(), theirs.max())
    key = (polygon[:, None] * most + mine[left]).ravel()
    their_key = (as_mine[their_polygon][:, None] * most + theirs[their_left]).ravel()
    corners, their_corners = _corners(left, np.arange(3)), _corners(their_left, np.arange(3))
    found, at = np.unique(key, return_index=True)
    their_found, their_at = np.unique(their_key, return_index=True)
    if not np.array_equal(found, their_found):
        raise difference
    return [
        Pairs(corners, their_corners[their_at[np.searchsorted(found, key)]]),
        Pairs(corners[at[np.searchsorted(found, their_key)]], their_corners),
    ]


def _edges(triangles: Numbers) -> Numbers:
    """``(F, 3, 2)``, from each corner to the next."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)


def _join(
    edges: Indices, directed: Indices, outline: NDArray[np.bool_], difference: Difference
) -> tuple[Indices, tuple[Indices, Indices]]:
    """Polygon ``(F,)`` of each triangle; the outlines' directed edges in their order, and the polygon of each.

    Parameters
    ----------
    edges, directed : ``(F, 3)`` numbers of the triangles' edges, without and with their direction.
    outline : ``(F, 3)`` which of them the other list has as well; two triangles meet at each of the others.
    difference : raised where that does not give polygons without holes.
    """
    triangle = np.broadcast_to(np.arange(len(edges))[:, None], edges.shape)
    order = np.argsort(edges[~outline], kind="stable")
    inner, meeting = edges[~outline][order], triangle[~outline][order]
    if (np.unique(inner, return_counts=True)[1] != 2).any():
        raise difference
    links = coo_array((np.ones(len(inner) // 2), (meeting[::2], meeting[1::2])), shape=(len(edges), len(edges)))
    polygon = connected_components(links, directed=False)[1].astype(np.intp)
    sides = directed[outline]
    whose = polygon[triangle[outline]]
    sorting = np.argsort(sides)
    # A polygon of n corners without holes is cut into n - 2 triangles.
    counts = np.bincount(whose, minlength=polygon.max() + 1) - 2
    if len(np.unique(sides)) < len(sides) or not np.array_equal(counts, np.bincount(polygon)):
        raise difference
    return polygon, (sides[sorting], whose[sorting])


def _difference(mine: Numbers, theirs: Numbers, left: Indices, their_left: Indices) -> Difference:
    if not len(their_left):
        what, first = f"{len(left)} of the neutral's {len(mine)} triangles are missing", left[0]
    elif not len(left):
        what, first = f"{len(their_left)} triangles are not the neutral's", their_left[0]
    elif _sets(theirs[their_left]) <= _sets(mine[left]):
        what, first = f"{len(their_left)} triangles are wound the other way round than the neutral's", their_left[0]
    else:
        what, first = f"{len(their_left)} of its {len(theirs)} triangles are not the neutral's", their_left[0]
    return Difference(f"{what}, the first of them number {first + 1}; fit the neutral's topology to the scan")


def _sets(triangles: Numbers) -> set[tuple[int, ...]]:
    return {tuple(triangle) for triangle in np.sort(triangles, axis=1).tolist()}
