"""Triangle meshes with one UV chart: reading and writing Wavefront OBJ without touching the vertex order.

Mesh libraries split vertices at UV seams or merge them; expressions must keep the order that they share, so the
few lines of OBJ that a blendshape needs are read here.
"""

import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading
from facezip.files.vertexblock import split_vertices

MAX_COORDINATE = 1e30
# Ten times a film's face. A line takes about a hundred bytes of memory while it is read.
MAX_BYTES = 2**28
MAX_LINES = 4_000_000
# Bytes of a line that the writer below makes, at most: three numbers such as -1.23456789e-10, or six large indices.
LONGEST_LINE = 80


@dataclass(frozen=True, eq=False)
class Topology:
    """What the meshes of one character share.

    Attributes
    ----------
    faces : ``(F, 3)`` int32, indices into the vertices.
    uv : ``(T, 2)`` float32, texture coordinates, v up.
    face_uv : ``(F, 3)`` int32, indices into ``uv``.
    """

    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    face_uv: NDArray[np.int32]

    def same_as(self, other: "Topology") -> bool:
        """Whether faces and UV layout agree exactly."""
        mine, theirs = (self.faces, self.uv, self.face_uv), (other.faces, other.uv, other.face_uv)
        return all(np.array_equal(a, b) for a, b in zip(mine, theirs, strict=True))


def read_obj(path: Path) -> tuple[NDArray[np.float32], Topology]:
    """Read vertices ``(V, 3)`` and topology from an OBJ file; polygons are split into triangle fans.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``TOO_LARGE``, or ``UNREADABLE_MESH``: not an OBJ, no vertices, faces or UVs,
        an index out of range, a coordinate that is not a finite number.
    """
    with reading(path):
        return _read_obj(path)


def _read_obj(path: Path) -> tuple[NDArray[np.float32], Topology]:
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such mesh; add the file or remove its texture")
    _check_length(path)
    text = path.read_bytes()
    try:
        vertices, layout = _vertices(text)
        return vertices, _topology(layout, len(vertices))
    except _MeshFault as fault:
        raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {fault}") from None


def _check_length(path: Path) -> None:
    """Refuse a file that would not stay small in memory, by what can be known without holding it."""
    lines = 0
    with open(path, "rb") as file:
        fits = os.fstat(file.fileno()).st_size <= MAX_BYTES
        while fits and (part := file.read(2**20)):
            lines += part.count(b"\n") + part.count(b"\r")
            fits = lines <= MAX_LINES
    if not fits:
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{path}: more than {MAX_LINES} lines or {MAX_BYTES >> 20} MB; a face has fewer, decimate it",
        )


def write_obj(path: Path, vertices: NDArray[np.float32], topology: Topology) -> None:
    """Write ``(V, 3)`` vertices and their topology as an OBJ file that :func:`read_obj` reads back bit for bit."""
    positions = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices.tolist())
    path.write_text(positions + _layout_text(topology), encoding="ascii", newline="\n")


# Every expression of a character repeats this text.
@lru_cache(maxsize=2)
def _layout_text(topology: Topology) -> str:
    corners = np.stack([topology.faces, topology.face_uv], axis=2).reshape(-1, 6) + 1
    lines = [f"vt {u:.9g} {v:.9g}\n" for u, v in topology.uv.tolist()]
    lines += [f"f {a}/{b} {c}/{d} {e}/{f}\n" for a, b, c, d, e, f in corners.tolist()]
    return "".join(lines)


class _MeshFault(ValueError):
    """What is wrong with a mesh, before the file's name is put in front."""


# The expressions of one character repeat the same faces and UVs: they are parsed once.
@lru_cache(maxsize=2)
def _topology(layout: bytes, vertex_count: int) -> Topology:
    lines = layout.splitlines()
    uv = _numbers(lines, b"vt", 2)
    indices = _resolve(_corners(lines), np.array([vertex_count, len(uv)]))
    return Topology(indices[:, :, 0].copy(), uv, indices[:, :, 1].copy())


def _vertices(text: bytes) -> tuple[NDArray[np.float32], bytes]:
    """The vertices ``(V, 3)``, and the text that holds the layout."""
    at_once = split_vertices(text)
    if at_once:
        values, layout = at_once
        return _finite(values, "v"), layout
    lines = text.splitlines()
    return _numbers(lines, b"v", 3), b"\n".join(line for line in lines if line.startswith((b"f ", b"vt ")))


def _numbers(lines: list[bytes], keyword: bytes, columns: int) -> NDArray[np.float32]:
    rows = [line for line in lines if line.startswith(keyword + b" ")]
    name = keyword.decode()
    if not rows:
        raise _MeshFault(f"the mesh has no '{name}' lines; export it as a polygon mesh with UVs")
    try:
        values = np.loadtxt(rows, usecols=range(1, columns + 1), comments=None, ndmin=2)
    except ValueError:
        raise _MeshFault(f"a '{name}' line does not hold {columns} numbers; export the mesh again") from None
    return _finite(values, name)


def _finite(values: NDArray[np.float64], name: str) -> NDArray[np.float32]:
    if not (np.abs(values) < MAX_COORDINATE).all():
        raise _MeshFault(f"a '{name}' line holds a NaN, an infinity or a huge number; repair the mesh")
    return values.astype(np.float32)


def _corners(lines: list[bytes]) -> NDArray[np.int64]:
    """``(F, 3, 2)`` raw vertex and UV indices, as numbered in the file."""
    polygons = [line.split()[1:] for line in lines if line.startswith(b"f ")]
    fans = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    if not fans:
        raise _MeshFault("the mesh has no faces; export it as a polygon mesh with UVs")
    try:
        pairs = [corner.split(b"/")[:2] for fan in fans for corner in fan]
        return np.array(pairs, dtype=np.int64).reshape(-1, 3, 2)
    except (ValueError, OverflowError):
        raise _MeshFault("a face corner is not 'vertex/uv'; export the mesh with UVs on every face") from None


def _resolve(corners: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int32]:
    """OBJ counts from 1, or from the end where negative."""
    indices = np.where(corners < 0, corners + counts, corners - 1)
    wrong = ((indices < 0) | (indices >= counts) | (corners == 0)).any(axis=(1, 2))
    if wrong.any():
        raise _MeshFault(
            f"triangle {int(wrong.argmax())} uses a vertex or UV that does not exist "
            f"({counts[0]} and {counts[1]} do); export the mesh again"
        )
    return indices.astype(np.int32)
