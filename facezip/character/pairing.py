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


def pair_corners(mine: Numbers, theirs: Numbers) -> Pairs | None:
    """Pair the corners of the same triangles, and of the same polygons where their triangles are others.

    Triangles are the same where their corners follow each other in the same order, polygons where their outlines do.

    Parameters
    ----------
    mine, theirs : ``(F, 3)`` and ``(F', 3)``, what lies at the corners of triangles: numbers of vertices, or of UVs.

    Returns
    -------
    None where there is a triangle that the other list does not have, alone or as a part of a polygon.
    """
    if np.array_equal(mine, theirs):
        return Pairs(np.arange(mine.size), np.arange(mine.size))
    orders, their_orders = _least_first(mine), _least_first(theirs)
    key, their_key, shared = _keys(np.take_along_axis(mine, orders, 1), np.take_along_axis(theirs, their_orders, 1))
    rows, their_rows = _by_key(key, shared), _by_key(their_key, shared)
    pairs = [Pairs(_corners(rows, orders[rows]), _corners(their_rows, their_orders[their_rows]))]
    left, their_left = np.flatnonzero(~shared[key]), np.flatnonzero(~shared[their_key])
    if len(left) or len(their_left):
        of_polygons = _pair_polygons(mine, theirs, left, their_left)
        if not of_polygons:
            return None
        pairs += of_polygons
    return Pairs(*(np.concatenate(each) for each in zip(*pairs, strict=True)))


def describe_difference(mine: Numbers, theirs: Numbers) -> str:
    """In what triangles ``(F', 3)`` differ from the neutral's ``(F, 3)``, first where, and what to do."""
    key, their_key, shared = _keys(*(np.take_along_axis(each, _least_first(each), 1) for each in (mine, theirs)))
    left, their_left = np.flatnonzero(~shared[key]), np.flatnonzero(~shared[their_key])
    counts = f"{len(theirs)} triangles, the neutral has {len(mine)}; " if len(theirs) != len(mine) else ""
    if not len(their_left):
        what = f"the neutral's triangle {left[0] + 1} is missing"
    else:
        first = theirs[their_left[0]]
        turned = np.isin(np.sort(mine[left], axis=1), np.sort(first)).all(axis=1).any() and len(np.unique(first)) == 3
        what = f"its triangle {their_left[0] + 1} is {'wound the other way round than' if turned else 'not one of'}"
        what += " the neutral's"
    return f"{counts}{what}; fit the neutral's topology to the scan"


def row_numbers(rows: Numbers) -> Indices:
    """Numbers ``(R,)`` from 0 of rows ``(R, C)`` of numbers from 0, the same for the same rows."""
    number = np.zeros(len(rows), np.int64)
    for column in rows.T:
        number = np.unique(number * (1 + column.max(initial=0)) + column, return_inverse=True)[1]
    return number


def _least_first(triangles: Numbers) -> Indices:
    """The order ``(F, 3)`` in which each triangle's corners begin with the least number."""
    return (triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3


def _keys(mine: Numbers, theirs: Numbers) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """Keys of rows, the same for the same ones, and which of the keys both have equally often."""
    key, their_key = np.split(row_numbers(np.concatenate([mine, theirs])), [len(mine)])
    bins = 1 + max(key.max(initial=0), their_key.max(initial=0))
    return key, their_key, np.bincount(key, minlength=bins) == np.bincount(their_key, minlength=bins)


def _by_key(key: Indices, shared: NDArray[np.bool_]) -> Indices:
    """The triangles whose key is shared, in the order of their keys and then of the file."""
    rows = np.flatnonzero(shared[key])
    return rows[np.argsort(key[rows], kind="stable")]


def _corners(rows: Indices, order: Indices) -> Indices:
    return (3 * rows[:, None] + order).ravel()


def _pair_polygons(mine: Numbers, theirs: Numbers, left: Indices, their_left: Indices) -> list[Pairs]:
    """Pair what is left over: triangles that meet at edges which the other list does not have are one polygon."""
    if len(left) != len(their_left):
        return []
    edges = np.concatenate([_edges(mine[left]), _edges(theirs[their_left])])
    undirected = row_numbers(np.sort(edges, axis=1)).reshape(2, -1, 3)
    directed = row_numbers(edges).reshape(2, -1, 3)
    joined = _join(undirected[0], directed[0], np.isin(undirected[0], undirected[1]))
    their_joined = _join(undirected[1], directed[1], np.isin(undirected[1], undirected[0]))
    if joined is None or their_joined is None or not np.array_equal(joined.sides, their_joined.sides):
        return []
    same = np.unique(np.stack([joined.whose, their_joined.whose]), axis=1)
    count = joined.polygon.max() + 1
    if not (same.shape[1] == count == their_joined.polygon.max() + 1):
        return []
    as_mine = np.empty(count, np.intp)
    as_mine[same[1]] = same[0]
    most = 1 + max(mine.max(), theirs.max())
    key = (joined.polygon[:, None] * most + mine[left]).ravel()
    their_key = (as_mine[their_joined.polygon][:, None] * most + theirs[their_left]).ravel()
    corners, their_corners = _corners(left, np.arange(3)), _corners(their_left, np.arange(3))
    found, at = np.unique(key, return_index=True)
    their_found, their_at = np.unique(their_key, return_index=True)
    if not np.array_equal(found, their_found):
        return []
    return [
        Pairs(corners, their_corners[their_at[np.searchsorted(found, key)]]),
        Pairs(corners[at[np.searchsorted(found, their_key)]], their_corners),
    ]


def _edges(triangles: Numbers) -> Numbers:
    """``(3 F, 2)``, from each corner to the next."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


class _Polygons(NamedTuple):
    """What triangles ``(F,)`` are joined to: their polygons; the outlines' edges in order, and the polygon of each."""

    polygon: Indices
    sides: Indices
    whose: Indices


def _join(edges: Indices, directed: Indices, outline: NDArray[np.bool_]) -> _Polygons | None:
    """Polygons of triangles with these edges ``(F, 3)``; None where they do not give any.

    Parameters
    ----------
    edges, directed : numbers of the triangles' edges, without and with their direction.
    outline : which of them the other list has as well; two triangles meet at each of the others.
    """
    triangle = np.broadcast_to(np.arange(len(edges))[:, None], edges.shape)
    order = np.argsort(edges[~outline], kind="stable")
    inner, meeting = edges[~outline][order], triangle[~outline][order]
    if (np.unique(inner, return_counts=True)[1] != 2).any():
        return None
    links = coo_array((np.ones(len(inner) // 2), (meeting[::2], meeting[1::2])), shape=(len(edges), len(edges)))
    polygon = connected_components(links, directed=False)[1].astype(np.intp)
    sides, whose = directed[outline], polygon[triangle[outline]]
    order = np.argsort(sides)
    if len(np.unique(sides)) < len(sides):
        return None
    return _Polygons(polygon, sides[order], whose[order])
