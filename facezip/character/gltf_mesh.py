"""The face of a glTF as a mesh: placed as its scene says, welded again where only UVs had split it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf_material import MIRRORED, REPEAT, Placement
from facezip.character.gltf_nodes import Nodes, described, is_mirror, leaves_alone, placed
from facezip.character.gltf_parts import Part
from facezip.character.meshes import Meshes
from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb
from facezip.files.obj import Topology
from facezip.files.objlists import MAX_COORDINATE
from facezip.files.reading import MOST_EXPANSION, SPARE

TRIANGLES, STRIP, FAN = 4, 5, 6
DRACO = "KHR_draco_mesh_compression"
# Of the side of a texture, by which UVs may stand out of it: what is drawn there is its border.
BORDER = 1 / 64


@dataclass(frozen=True, eq=False)
class _Piece:
    """One primitive: ``shapes`` ``(N + 1, V, 3)``, neutral first, ``uv`` ``(V, 2)`` v down, ``faces`` ``(F, 3)``."""

    shapes: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int64]


def read_mesh(glb: Glb, part: Part, placement: Placement) -> tuple[Meshes, list[str]]:
    """The geometry of a part with its textures placed so, v up; and what was done to it, in words.

    ``GlbFault`` where it is damaged, compressed, or out of proportion to its file.
    """
    nodes, pieces, done = Nodes(glb), [], dict[str, None]()
    for primitive in part.primitives:
        piece = _piece(glb, primitive, placement)
        matrix = nodes.placements(part.mesh, primitive, piece.shapes.shape[1])
        if not leaves_alone(matrix):
            done[described(matrix)] = None
            piece = _moved(piece, matrix)
        pieces.append(piece)
    if (shown := len(nodes.showing(part.mesh))) > 1:
        done[f"{shown} nodes show it; it is read where the first of them does"] = None
    if placement.moves:
        done["UVs are moved as its texture transform says"] = None
    starts = np.cumsum([0, *(len(piece.uv) for piece in pieces)])
    faces = np.concatenate([piece.faces + start for piece, start in zip(pieces, starts, strict=False)])
    shapes = np.concatenate([piece.shapes for piece in pieces], axis=1)
    uv, face_uv = np.concatenate([piece.uv for piece in pieces]), faces
    inside = _in_the_square(uv[faces], placement.wrap)
    if inside is not None:
        done["UVs are moved into the unit square by whole units, as its texture repeats"] = None
        uv, face_uv = inside.reshape(-1, 2), np.arange(inside.size // 2).reshape(-1, 3)
    return _welded(shapes, faces, uv, face_uv), list(done)


def _welded(
    shapes: NDArray[np.float32], faces: NDArray[np.int64], uv: NDArray[np.float32], face_uv: NDArray[np.int64]
) -> Meshes:
    # Parts may share their vertices, of which this one uses some.
    used, faces = np.unique(faces, return_inverse=True)
    used_uv, face_uv = np.unique(face_uv, return_inverse=True)
    welded, vertex = _weld(shapes[:, used].swapaxes(0, 1).reshape(len(used), -1))
    layout, coordinate = _weld(uv[used_uv])
    # v up, as everywhere here.
    layout = np.stack([layout[:, 0], 1 - layout[:, 1]], axis=1)
    every = welded.reshape(len(welded), -1, 3).swapaxes(0, 1)
    topology = Topology(vertex[faces], layout, coordinate[face_uv])
    return Meshes(topology, every[0].copy(), np.ascontiguousarray(every[1:]))


def _piece(glb: Glb, primitive: GltfObject, placement: Placement) -> _Piece:
    attributes, targets = primitive["attributes"], primitive["targets"]
    if DRACO in primitive.get("extensions", {}) and not _has_bytes(glb, attributes.get("POSITION")):
        raise GlbFault(f"it is compressed by {DRACO}, which is not read; export it uncompressed")
    neutral = _positions(glb, attributes.get("POSITION"), None)
    # A target without bytes is a legitimate one, which moves nothing, but so many of them are not.
    if neutral.nbytes * (len(targets) + 1) > max(SPARE, MOST_EXPANSION * glb.bytes_held):
        raise GlbFault(f"{len(targets)} targets of {len(neutral)} vertices in {glb.bytes_held} bytes; export it again")
    moved = [neutral + _positions(glb, target.get("POSITION"), len(neutral)) for target in targets]
    uv = _texture_coordinates(glb, primitive, placement, len(neutral))
    return _Piece(np.stack([neutral, *moved]), uv, _faces(glb, primitive, len(neutral)))


def _has_bytes(glb: Glb, accessor: Any) -> bool:
    return "bufferView" in glb.item("accessors", accessor)


def _moved(piece: _Piece, matrix: NDArray[np.float64]) -> _Piece:
    shapes = np.stack([placed(shape, matrix) for shape in piece.shapes])
    if not (np.abs(shapes) < MAX_COORDINATE).all():
        raise GlbFault("its nodes move it so far that no position is exact; move it to the origin")
    return _Piece(shapes, piece.uv, piece.faces[:, ::-1] if is_mirror(matrix) else piece.faces)


def _positions(glb: Glb, accessor: Any, count: int | None) -> NDArray[np.float32]:
    """``(K, 3)`` float32, ``count`` of them where given; zeros for a target that moves nothing."""
    if accessor is None and count is not None:
        return np.zeros((count, 3), np.float32)
    values = glb.array(accessor)
    if values.shape[1:] != (3,) or len(values) == 0 or (count is not None and len(values) != count):
        raise GlbFault("positions and morph targets are not of one size; export it again")
    if not (np.abs(values) < MAX_COORDINATE).all():
        raise GlbFault("a position is NaN, infinite or huge; repair the mesh")
    return values.astype(np.float32)


def _texture_coordinates(glb: Glb, primitive: GltfObject, placement: Placement, count: int) -> NDArray[np.float32]:
    name = f"TEXCOORD_{placement.coordinates}"
    if name not in primitive["attributes"]:
        raise GlbFault(f"its face has no UVs ({name}); unwrap it")
    values = glb.array(primitive["attributes"][name])
    if values.shape != (count, 2) or not (np.abs(values) < MAX_COORDINATE).all():
        raise GlbFault("its UVs are not one finite pair a vertex; export it again")
    if not placement.moves:
        return values.astype(np.float32)
    u, v = values.astype(np.float64).T
    return np.stack([a * u + b * v + c for a, b, c in (placement.across, placement.down)], axis=1).astype(np.float32)


def _in_the_square(corners: NDArray[np.float32], wrap: tuple[int, int]) -> NDArray[np.float32] | None:
    """UVs ``(F, 3, 2)`` of triangles, each moved by whole units to where its texture is; None where all are there.

    Where a sampler does not repeat its texture, what lies outside shows the border, here as everywhere.
    """
    flat = corners.reshape(-1, 2)
    outside = (flat.min(axis=0) < -BORDER) | (flat.max(axis=0) > 1 + BORDER)
    for axis, name in enumerate("uv"):
        if outside[axis] and wrap[axis] == MIRRORED:
            raise GlbFault(f"its {name} leaves the unit square, where its texture is mirrored; bring all UVs inside")
    repeats = outside & (np.array(wrap) == REPEAT)
    if not repeats.any():
        return None
    moved = corners - np.where(repeats, np.floor(corners.mean(axis=1)), 0)[:, None].astype(np.float32)
    if (moved[..., repeats] < -BORDER).any() or (moved[..., repeats] > 1 + BORDER).any():
        raise GlbFault("a triangle of it reaches over the border of a texture that repeats; bring all UVs inside")
    return moved


def _faces(glb: Glb, primitive: GltfObject, count: int) -> NDArray[np.int64]:
    mode = primitive.get("mode", TRIANGLES)
    if mode not in (TRIANGLES, STRIP, FAN):
        raise GlbFault("its face is not of triangles; export it as triangles")
    indices = glb.array(primitive["indices"]) if "indices" in primitive else np.arange(count)[:, None]
    is_whole = len(indices) % 3 == 0 if mode == TRIANGLES else len(indices) >= 3
    if indices.shape[1] != 1 or indices.dtype.kind not in "ui" or not is_whole or len(indices) == 0:
        raise GlbFault("its triangles are not threes of vertex numbers; export it again")
    if indices.max() >= count:
        raise GlbFault("a triangle uses a vertex that does not exist; export it again")
    row = indices[:, 0].astype(np.int64)
    if mode == TRIANGLES:
        return row.reshape(-1, 3)
    if mode == FAN:
        return np.stack([row[1:-1], row[2:], np.broadcast_to(row[0], len(row) - 2)], axis=1)
    triangles = np.stack([row[:-2], row[1:-1], row[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [0, 2, 1]]
    # A strip turns back by triangles of two equal corners.
    first, second, third = triangles.T
    return triangles[(first != second) & (second != third) & (third != first)]


def _weld(rows: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Equal rows made one, in the order in which they first appear; and which one each was."""
    rows = np.ascontiguousarray(rows + np.float32(0))  # no negative zeros
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1])))[:, 0]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return rows[first[order]], rank[inverse]
