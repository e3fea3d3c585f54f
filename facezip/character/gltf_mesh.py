"""The one mesh of a GLB that has morph targets, welded again where only UVs had split it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import MAX_EXPRESSIONS
from facezip.files.glb import Glb, GlbFault
from facezip.files.obj import MAX_COORDINATE, Topology
from facezip.files.reading import MOST_EXPANSION, SPARE

TRIANGLES = 4


@dataclass(frozen=True, eq=False)
class ScannedMesh:
    """Geometry of a character.

    Attributes
    ----------
    names : the N morph targets' names.
    topology : faces and UV layout, v up.
    neutral : ``(V, 3)`` float32.
    vertices : ``(N, V, 3)`` float32, absolute positions.
    primitive : the JSON that the mesh came from.
    """

    names: tuple[str, ...]
    topology: Topology
    neutral: NDArray[np.float32]
    vertices: NDArray[np.float32]
    primitive: dict[str, Any]


def read_mesh(glb: Glb) -> ScannedMesh:
    """Read the mesh with morph targets; ``GlbFault`` where there is none, more than one, or one out of proportion."""
    index, names, primitive = _morphing(glb)
    neutral = _positions(glb, primitive["attributes"].get("POSITION"), None)
    # A target without bytes is a legitimate one, which moves nothing, but so many of them are not.
    if neutral.nbytes * (len(names) + 1) > max(SPARE, MOST_EXPANSION * len(glb.binary)):
        raise GlbFault(f"{len(names)} targets of {len(neutral)} vertices in {len(glb.binary)} bytes; export it again")
    deltas = [_positions(glb, target.get("POSITION"), len(neutral)) for target in primitive["targets"]]
    turn = _transform(glb, index)
    neutral, shapes = neutral @ turn.T, [(neutral + delta) @ turn.T for delta in deltas]
    uv = _texture_coordinates(glb, primitive, len(neutral))
    faces = _faces(glb, primitive, len(neutral))
    welded, vertex = _weld(np.concatenate([neutral, *shapes], axis=1).astype(np.float32))
    layout, coordinate = _weld(uv)
    # v up, as everywhere here.
    layout = np.stack([layout[:, 0], 1 - layout[:, 1]], axis=1)
    topology = Topology(vertex[faces], layout, coordinate[faces])
    every = welded.reshape(len(welded), -1, 3).swapaxes(0, 1)
    return ScannedMesh(names, topology, every[0].copy(), np.ascontiguousarray(every[1:]), primitive)


def _morphing(glb: Glb) -> tuple[int, tuple[str, ...], dict[str, Any]]:
    """Number, target names and the only primitive of the mesh with targets."""
    meshes = [glb.item("meshes", index) for index in range(len(glb.document.get("meshes", [])))]
    found = [index for index, mesh in enumerate(meshes) if any(part.get("targets") for part in mesh["primitives"])]
    if len(found) != 1 or len(meshes[found[0]]["primitives"]) != 1:
        raise GlbFault(
            f"{len(found)} meshes have morph targets; one mesh with one material, the face, has to"
            if len(found) != 1
            else "its face has several materials; give it one"
        )
    mesh = meshes[found[0]]
    primitive = mesh["primitives"][0]
    if primitive.get("mode", TRIANGLES) != TRIANGLES:
        raise GlbFault("its face is not of triangles; export it as triangles")
    names = mesh.get("extras", {}).get("targetNames", [])
    count = len(primitive["targets"])
    if len(names) != count or len({*map(str, names)}) != count or not all(isinstance(name, str) for name in names):
        raise GlbFault("its morph targets have no names of their own (extras.targetNames); name them and export again")
    if not 2 <= count <= MAX_EXPRESSIONS:
        raise GlbFault(f"{count} morph target(s); 2 to {MAX_EXPRESSIONS} besides the neutral")
    return found[0], tuple(names), primitive


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


def _texture_coordinates(glb: Glb, primitive: dict[str, Any], count: int) -> NDArray[np.float32]:
    if "TEXCOORD_0" not in primitive["attributes"]:
        raise GlbFault("its face has no UVs (TEXCOORD_0); unwrap it")
    values = glb.array(primitive["attributes"]["TEXCOORD_0"])
    if values.shape != (count, 2) or not (np.abs(values) < MAX_COORDINATE).all():
        raise GlbFault("its UVs are not one finite pair a vertex; export it again")
    return values.astype(np.float32)


def _faces(glb: Glb, primitive: dict[str, Any], count: int) -> NDArray[np.int64]:
    indices = glb.array(primitive["indices"]) if "indices" in primitive else np.arange(count)[:, None]
    if indices.shape[1] != 1 or indices.dtype.kind not in "ui" or len(indices) % 3 or len(indices) == 0:
        raise GlbFault("its triangles are not threes of vertex numbers; export it again")
    if indices.max() >= count:
        raise GlbFault("a triangle uses a vertex that does not exist; export it again")
    return indices.astype(np.int64).reshape(-1, 3)


def _weld(rows: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Equal rows made one, in the order in which they first appear; and which one each was."""
    rows = np.ascontiguousarray(rows + np.float32(0))  # no negative zeros
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1])))[:, 0]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return rows[first[order]], rank[inverse]


def _transform(glb: Glb, mesh: int) -> NDArray[np.float32]:
    """``(3, 3)``: how nodes turn and stretch the mesh. Place and size do not matter: characters have any unit."""
    nodes = [glb.item("nodes", index) for index in range(len(glb.document.get("nodes", [])))]
    parents = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
    at = next((index for index, node in enumerate(nodes) if node.get("mesh") == mesh), None)
    total, seen = np.eye(3), set[int]()
    with np.errstate(all="ignore"):
        while at is not None and at not in seen:
            seen.add(at)
            total = _linear(nodes[at]) @ total
            at = parents.get(at)
        size = np.cbrt(abs(np.linalg.det(total)))
        unit = total / size
    if not 1e-12 < size < 1e12 or not np.abs(unit).max() < 1e6:
        raise GlbFault("its node has a transform that flattens it or is no number; export it again")
    exact = np.eye(3) if np.allclose(unit, np.eye(3), atol=1e-6) else unit
    return exact.astype(np.float32)


def _linear(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T[:3, :3]
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), float)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return turn * np.array(node.get("scale", (1, 1, 1)), float)
