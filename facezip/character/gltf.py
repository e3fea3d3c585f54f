"""The geometry of a character as glTF: corners split where UVs differ, morph targets that keep their names."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.files.accessors import GltfObject
from facezip.files.glb_builder import INDICES, VERTICES, GlbBuilder
from facezip.files.obj import Topology
from facezip.version import __version__

# A normal that turns by less than this cannot be seen, and takes bytes.
SMALLEST_TURN = 1e-3
ROUGHNESS = 0.6
# Trilinear, clamped.
CLAMPED = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}]


@dataclass(frozen=True, eq=False)
class Split:
    """Vertices as a GPU wants them: one position and one UV each.

    Attributes
    ----------
    vertex : ``(K,)`` the mesh's vertex that each comes from, ascending, so that a reader that welds them again finds
        the order of the mesh.
    uv : ``(K, 2)`` float32, v down as glTF has it.
    faces : ``(F, 3)`` uint32, indices into those.
    """

    vertex: NDArray[np.int64]
    uv: NDArray[np.float32]
    faces: NDArray[np.uint32]


def split(topology: Topology) -> Split:
    """Make one vertex of every pair of position and UV that a corner uses."""
    pairs = np.stack([topology.faces, topology.face_uv], axis=2).reshape(-1, 2).astype(np.int64)
    keys, corners = np.unique(pairs[:, 0] << 32 | pairs[:, 1], return_inverse=True)
    uv = topology.uv[keys & 0xFFFFFFFF]
    flipped = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype(np.float32)
    return Split(keys >> 32, flipped, corners.reshape(-1, 3).astype(np.uint32))


def start(name: str) -> GlbBuilder:
    """An empty file with one scene that shows one mesh."""
    return GlbBuilder(
        {
            "asset": {"version": "2.0", "generator": f"facezip {__version__}"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": name, "mesh": 0}],
        }
    )


def add_mesh(
    glb: GlbBuilder, name: str, meshes: Meshes, expressions: tuple[str, ...], charts: Sequence[Topology]
) -> list[GltfObject]:
    """Add the neutral and a named morph target per expression (equation 7), with a primitive for each of ``charts``.

    Normals are computed on the mesh before it is split, so that no seam shows, and morph along. The number of a chart
    is that of its material. Returns the primitives.
    """
    normals = vertex_normals(meshes.neutral, meshes.topology.faces)
    turns = []
    for delta in meshes.deltas:
        turned = vertex_normals(meshes.neutral + delta, meshes.topology.faces) - normals
        turned[np.abs(turned).max(axis=1) < SMALLEST_TURN] = 0
        turns.append(turned)
    primitives = [
        _primitive(glb, meshes, normals, turns, split(chart), material)
        for material, chart in enumerate(charts)
        # No face may lie on a tile, and glTF has no empty primitive.
        if len(chart.faces)
    ]
    glb.document["meshes"] = [
        {
            "name": name,
            "primitives": primitives,
            "weights": [0.0] * len(expressions),
            "extras": {"targetNames": list(expressions)},
        }
    ]
    return primitives


def _primitive(
    glb: GlbBuilder,
    meshes: Meshes,
    normals: NDArray[np.float32],
    turns: Sequence[NDArray[np.float32]],
    parts: Split,
    material: int,
) -> GltfObject:
    faces = parts.faces.astype(np.uint16) if len(parts.vertex) <= 65535 else parts.faces
    return {
        "attributes": {
            "POSITION": glb.array(meshes.neutral[parts.vertex], VERTICES, bounds=True),
            "NORMAL": glb.array(normals[parts.vertex], VERTICES),
            "TEXCOORD_0": glb.array(parts.uv, VERTICES),
        },
        "indices": glb.array(faces.reshape(-1, 1), INDICES),
        "material": material,
        "targets": [
            {"POSITION": glb.sparse(delta[parts.vertex], bounds=True), "NORMAL": glb.sparse(turned[parts.vertex])}
            for delta, turned in zip(meshes.deltas, turns, strict=True)
        ],
    }


def skin(name: str, texture: int, normal: int | None = None, roughness: int | None = None) -> GltfObject:
    """A material of that name and base colour; ``normal`` and ``roughness`` are textures too, where there are any."""
    shading: GltfObject = {"baseColorTexture": {"index": texture}, "metallicFactor": 0.0}
    if roughness is None:
        shading["roughnessFactor"] = ROUGHNESS
    else:
        shading["metallicRoughnessTexture"] = {"index": roughness}
    material = {"name": name, "pbrMetallicRoughness": shading}
    return material if normal is None else {**material, "normalTexture": {"index": normal}}


def vertex_normals(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Unit normals ``(V, 3)`` of the welded mesh, weighted by area; +z where a vertex has no face."""
    corners = vertices[faces].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros((len(vertices), 3))
    for corner in range(3):
        np.add.at(sums, faces[:, corner], across)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    units = np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), [0.0, 0.0, 1.0])
    return units.astype(np.float32)
