"""Triangle meshes with one UV chart: reading and writing Wavefront OBJ without touching the vertex order.

Expressions must keep the order that they share, so a reader has to give the file's own vertices, UVs and indices. Of
twelve kept ones (docs/meshes.md) none does so for all valid spellings, and none says what it leaves out.
"""

import codecs
import os
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading

if TYPE_CHECKING:
    from facezip.files.objlines import Lines

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
    materials : names of the materials that faces have, in the order of the file; "" for none.
    face_material : ``(F,)`` int, indices into ``materials``; None where there is only one.
    """

    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    face_uv: NDArray[np.int32]
    materials: tuple[str, ...] = ("",)
    face_material: NDArray[np.intp] | None = None


def used_rows(rows: NDArray[Any], indices: NDArray[np.integer]) -> NDArray[Any]:
    """Those of the rows ``(R, C)`` that some indices name, in their order."""
    used = np.zeros(len(rows), np.bool_)
    used[indices] = True
    return rows[used]


def only_materials(
    vertices: NDArray[np.float32], topology: Topology, names: Collection[str]
) -> tuple[NDArray[np.float32], Topology]:
    """The faces of some materials, with the vertices ``(V, 3)`` and UVs that they use, in their order.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME``: there is no such material.
    """
    missing = next((name for name in names if name not in topology.materials), None)
    if missing is not None:
        known = ", ".join(f"'{material}'" for material in topology.materials)
        raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"no material '{missing}'; this mesh has {known}")
    if topology.face_material is None:
        return vertices, topology
    kept = [number for number, name in enumerate(topology.materials) if name in names]
    mine = np.isin(topology.face_material, kept)
    used, faces = np.unique(topology.faces[mine], return_inverse=True)
    used_uv, face_uv = np.unique(topology.face_uv[mine], return_inverse=True)
    part = Topology(
        faces.astype(np.int32).reshape(-1, 3),
        topology.uv[used_uv],
        face_uv.astype(np.int32).reshape(-1, 3),
        tuple(topology.materials[number] for number in kept),
        np.searchsorted(kept, topology.face_material[mine]) if len(kept) > 1 else None,
    )
    return vertices[used], part


def read_obj(path: Path) -> tuple[NDArray[np.float32], Topology]:
    """Read vertices ``(V, 3)`` and topology from an OBJ file; polygons are split into fans from their first corner.

    Every line counts: one that is not understood is refused with its number (:mod:`facezip.files.objlines`).

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``TOO_LARGE``, or ``UNREADABLE_MESH``: a line that is not OBJ, no vertices,
        faces or UVs, a face without UVs, an index out of range, a coordinate that is not a finite number.
    """
    with reading(path):
        if not path.is_file():
            raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such mesh; add the file or remove its texture")
        try:
            return _mesh(_text(path))
        except _MeshFault as fault:
            raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {fault}") from None


def may_be_cut(path: Path) -> bool:
    """Whether a file ends within a line, as one does that was not written to its end, in any encoding."""
    with open(path, "rb") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - 2))
        return not _ends(file.read().rstrip(b"\0"))


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


def _text(path: Path) -> bytearray:
    """The bytes of a file as UTF-8 without a byte order mark; never more than stays small in memory."""
    # A compiler comes with it: whoever reads no mesh, as `facezip info`, does not wait for that.
    from facezip.files.objlists import PART, occurrences

    text, lines = bytearray(), 0
    with open(path, "rb") as file:
        fits = os.fstat(file.fileno()).st_size <= MAX_BYTES
        while fits and (part := file.read(PART)):
            text += part
            lines += occurrences(part, b"\n") + occurrences(part, b"\r")
            fits = lines <= MAX_LINES
    if not fits:
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{path}: more than {MAX_LINES} lines or {MAX_BYTES >> 20} MB; a face has fewer, decimate it",
        )
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            return bytearray(text.decode("utf-16").encode())
        except UnicodeDecodeError:
            raise _MeshFault("begins as UTF-16 and goes on as something else; export the mesh again") from None
    if text.startswith(codecs.BOM_UTF8):
        del text[: len(codecs.BOM_UTF8)]
    return text


def _mesh(text: bytearray) -> tuple[NDArray[np.float32], Topology]:
    from facezip.files.objlines import LineFault, Lines

    try:
        lines = Lines(text)
    except LineFault as fault:
        raise _MeshFault(str(fault)) from None
    for key, rows in (("v", lines.vertices), ("vt", lines.uv), ("f", lines.face_ends)):
        if not len(rows):
            cut = ", and its last line does not end: it may be cut off" if text and not _ends(text) else ""
            raise _MeshFault(f"the mesh has no '{key}' lines{cut}; export it as a polygon mesh with UVs")
    _check_range(lines)
    triangles, polygon = _fans(lines.corners, lines.face_ends)
    faces, face_uv = triangles[:, :, 0].copy(), triangles[:, :, 1].copy()
    return lines.vertices, Topology(faces, lines.uv, face_uv, *_materials(lines.materials, polygon))


def _ends(text: bytes | bytearray) -> bool:
    return text.endswith((b"\n", b"\r"))


def _check_range(lines: "Lines") -> None:
    for column, (what, exist) in enumerate((("vertex", len(lines.vertices)), ("UV", len(lines.uv)))):
        indices = lines.corners[:, column]
        if indices.max() >= exist:
            corner = int((indices >= exist).argmax())
            line = lines.number_of_corner(corner)
            raise _MeshFault(
                f"line {line}: there is no {what} {indices[corner] + 1}, the mesh has {exist}; export it again"
            )


def _fans(corners: NDArray[np.int32], ends: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.intp]]:
    """Triangles ``(F, 3, 2)`` of polygons whose corners end at ``ends``, and the polygon ``(F,)`` that each is of."""
    begins = np.concatenate([[0], ends[:-1]])
    triangles = ends - begins - 2
    polygon = np.repeat(np.arange(len(ends)), triangles)
    if len(polygon) == len(ends):
        return corners.reshape(-1, 3, 2), polygon
    step = np.arange(len(polygon)) - (np.cumsum(triangles) - triangles)[polygon]
    first = begins[polygon]
    return corners[np.stack([first, first + step + 1, first + step + 2], axis=1)], polygon


def _materials(
    changes: list[tuple[int, str]], polygon: NDArray[np.intp]
) -> tuple[tuple[str, ...], NDArray[np.intp] | None]:
    """Names that triangles have and which of them each has, by how many polygons came before each change."""
    if not changes:
        return ("",), None
    numbers = {"": 0}
    number = np.array([0, *(numbers.setdefault(name, len(numbers)) for _, name in changes)])
    change = np.searchsorted([before for before, _ in changes], polygon, side="right")
    used, face_material = np.unique(number[change], return_inverse=True)
    names = list(numbers)
    return tuple(names[k] for k in used), face_material if len(used) > 1 else None
