"""Whether triangles lie where there are textures: on tiles that have some, or in the one unit square."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from facezip.character.notes import Note
from facezip.character.raster import covered
from facezip.character.tiles import FIRST_TILE, LAST_TILE, place_of
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology, used_rows

# Of the unit square: what copies of one UV may be apart.
ALIKE = 2.0**-20
# Of a texel: what the last digit of a UV may be.
LAST_DIGIT = 1 / 16
# To see whether charts lie on each other, and the share of the smaller that may, where they meet.
SIDE, TOUCHING = 256, 0.02
# Unit squares that a mesh may span before its UVs are no layout.
MOST_SQUARES = 4096


def in_unit_square(path: Path, topology: Topology, texel: float) -> tuple[Topology, list[Note]]:
    """UVs of a mesh that has one texture, which renderers repeat: charts in other unit squares are moved back.

    Parameters
    ----------
    path : the mesh's file.
    topology : its triangles.
    texel : the side of a texel in UV; as far may UVs lie beside the square.

    Raises
    ------
    FaceZipError
        ``UNREADABLE_MESH``: a chart crosses the square's border, charts would come to lie on each other, or UVs are so
        large that they have no digits left for a texel.
    """
    used = used_rows(topology.uv, topology.face_uv)
    if (used >= -texel).all() and (used <= 1 + texel).all():
        return topology, []
    _check_digits(path, used, texel)
    chart = _charts(topology)
    low, high = _extents(topology, chart)
    square = np.where((low >= -texel) & (high <= 1 + texel), 0, np.floor((low + high) / 2))
    across = np.asarray(((low < square - texel) | (high > square + 1 + texel)).any(axis=1))
    if across.any():
        raise _across(path, chart, across, low, high)
    _check_apart(path, topology, chart, square)
    uv = topology.uv.copy()
    uv[topology.face_uv] -= square[chart][:, None].astype(np.float32)
    moved: NDArray[np.bool_] = (square != 0).any(axis=1)
    words = f"{moved[chart].mean():.0%} of its triangles had UVs in other unit squares; moved into the first"
    several = len(np.unique(square, axis=0)) > 1
    return replace(topology, uv=uv), [Note(path.name, words, asks=several)]


def check_on_tiles(path: Path, topology: Topology, tiles: tuple[int, ...], texel: float) -> tuple[int, ...]:
    """Those of the tiles on which no triangle lies.

    Raises
    ------
    FaceZipError
        ``UNREADABLE_MESH``: triangles reach onto a tile that is none of ``tiles``, or so large UVs.
    """
    corners = topology.uv[topology.face_uv].astype(np.float64)
    _check_digits(path, corners, texel)
    low, high = corners.min(axis=1) + texel, corners.max(axis=1) - texel
    first = np.floor(np.minimum(low, (low + high) / 2)).astype(np.int64)
    last = np.maximum(np.ceil(high).astype(np.int64) - 1, first)
    textured = {place_of(tile) for tile in tiles}
    empty = {*textured}
    for square in _squares(path, first, last):
        on = ((first <= square) & (last >= square)).all(axis=1)
        on[on] = _overlap(corners[on], np.array(square), texel)
        if on.any() and square not in textured:
            raise _without_texture(path, square, on)
        if on.any():
            empty.discard(square)
    return tuple(tile for tile in tiles if place_of(tile) in empty)


def _check_digits(path: Path, uv: NDArray[np.floating], texel: float) -> None:
    largest = np.abs(uv).max()
    if np.spacing(np.float32(largest)) > LAST_DIGIT * texel:
        raise FaceZipError(
            ErrorCode.UNREADABLE_MESH,
            f"{path}: UVs of up to {largest:.3g} have no digits left for a texel; move them into the unit square",
        )


def _charts(topology: Topology) -> NDArray[np.intp]:
    """Numbers ``(F,)`` of the charts, triangles joined by UVs at one place."""
    _, point = np.unique(np.rint(topology.uv.astype(np.float64) / ALIKE), axis=0, return_inverse=True)
    corners = point.ravel()[topology.face_uv]
    pairs = np.concatenate([corners[:, :2], corners[:, 1:]])
    count = int(corners.max()) + 1
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels = connected_components(links, directed=False)[1][corners[:, 0]]
    return np.unique(labels, return_inverse=True)[1].ravel()


def _extents(topology: Topology, chart: NDArray[np.intp]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and the largest UV of every chart, ``(K, 2)`` each."""
    corners = topology.uv[topology.face_uv].astype(np.float64)
    low, high = (np.full((chart.max() + 1, 2), end) for end in (np.inf, -np.inf))
    np.minimum.at(low, chart, corners.min(axis=1))
    np.maximum.at(high, chart, corners.max(axis=1))
    return low, high


def _across(
    path: Path,
    chart: NDArray[np.intp],
    across: NDArray[np.bool_],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> FaceZipError:
    first, wrong = int(np.flatnonzero(across)[0]), across[chart]
    (u, v), (to_u, to_v) = low[first], high[first]
    return FaceZipError(
        ErrorCode.UNREADABLE_MESH,
        f"{path}: UVs from ({u:.4g}, {v:.4g}) to ({to_u:.4g}, {to_v:.4g}) lie outside of the unit square and across "
        f"its border, of {wrong.mean():.0%} of the triangles, and there is one texture: move the chart into the "
        f"square, or name textures by their tiles (neutral.{FIRST_TILE}.png, neutral.{FIRST_TILE + 1}.png)",
    )


def _check_apart(path: Path, topology: Topology, chart: NDArray[np.intp], square: NDArray[np.float64]) -> None:
    """Charts of several squares may be tiles whose textures are missing: laid on each other they would share texels."""
    squares, group = np.unique(square, axis=0, return_inverse=True)
    taken = np.zeros((SIDE, SIDE), np.bool_)
    for number, offset in enumerate(squares if len(squares) > 1 else ()):
        own = (group.ravel() == number)[chart]
        uv = topology.uv - offset.astype(np.float32)
        part = replace(topology, faces=topology.faces[own], uv=uv, face_uv=topology.face_uv[own])
        seen = covered(part, (SIDE, SIDE))
        if (seen & taken).sum() > TOUCHING * max(min(seen.sum(), taken.sum()), 1):
            raise FaceZipError(
                ErrorCode.UNREADABLE_MESH,
                f"{path}: UVs lie in {len(squares)} unit squares, in the same places, and there is one texture: name "
                f"textures by their tiles (neutral.{FIRST_TILE}.png, neutral.{FIRST_TILE + 1}.png), or lay the charts "
                "beside each other in one square",
            )
        taken |= seen


def _squares(path: Path, first: NDArray[np.int64], last: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Columns and rows of all unit squares that triangles may touch."""
    (left, below), (right, above) = first.min(axis=0).tolist(), last.max(axis=0).tolist()
    if (right - left + 1) * (above - below + 1) > MOST_SQUARES:
        raise FaceZipError(
            ErrorCode.UNREADABLE_MESH,
            f"{path}: UVs from ({left}, {below}) to ({right + 1}, {above + 1}), far outside of all tiles; unwrap it",
        )
    touched = np.zeros((above - below + 1, right - left + 1), np.bool_)
    for (column, row), (to_column, to_row) in np.unique(np.stack([first, last], axis=1), axis=0).tolist():
        touched[row - below : to_row - below + 1, column - left : to_column - left + 1] = True
    yield from ((int(column) + left, int(row) + below) for row, column in np.argwhere(touched))


def _overlap(corners: NDArray[np.float64], square: NDArray[np.int64], texel: float) -> NDArray[np.bool_]:
    """Which triangles ``(K, 3, 2)`` share more than a texel's width with a unit square, by separating axes."""
    middle, half = square + 0.5, 0.5 - texel
    edges = np.roll(corners, -1, axis=1) - corners
    apart = np.zeros(len(corners), np.bool_)
    for normals in np.moveaxis(np.stack([-edges[..., 1], edges[..., 0]], axis=2), 1, 0):
        along = np.einsum("kcd,kd->kc", corners - middle, normals)
        reach = half * np.abs(normals).sum(axis=1)
        apart |= (along.min(axis=1) >= reach) | (along.max(axis=1) <= -reach)
    inside = (corners.min(axis=1) < middle + half) & (corners.max(axis=1) > middle - half)
    overlap: NDArray[np.bool_] = inside.all(axis=1) & ~apart
    return overlap


def _without_texture(path: Path, square: tuple[int, int], on: NDArray[np.bool_]) -> FaceZipError:
    column, row = square
    number = FIRST_TILE + column + 10 * row
    is_tile = 0 <= column < 10 and row >= 0 and number <= LAST_TILE
    where = f"tile {number}" if is_tile else f"the unit square at ({column}, {row}), outside of all tiles"
    remedy = f"add neutral.{number}.png and those of the expressions, or " if is_tile else ""
    return FaceZipError(
        ErrorCode.UNREADABLE_MESH,
        f"{path}: {on.sum()} of {len(on)} triangles, the first of them number {int(on.argmax()) + 1}, reach onto "
        f"{where}, which has no textures; {remedy}move their UVs",
    )
