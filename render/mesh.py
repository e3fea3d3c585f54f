"""A character's mesh in Mitsuba, whose vertices can be moved from expression to expression."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import vertex_normals
from facezip.files.obj import Topology
from scenes.plugins import Plugin

NAME = "head"


class HeadMesh:
    """One Mitsuba mesh for all expressions of a character, for one scene.

    Vertices are split where UVs differ; normals are computed on the mesh before the split, so that no crease shows
    at a UV seam.

    Parameters
    ----------
    topology : faces and UV layout.
    bsdf : a Mitsuba BSDF dict.
    """

    def __init__(self, topology: Topology, bsdf: Plugin) -> None:
        import mitsuba as mi

        corners = np.stack([topology.faces, topology.face_uv], axis=2).reshape(-1, 2)
        pairs, index = np.unique(corners, axis=0, return_inverse=True)
        self._topology = topology
        self._source = pairs[:, 0]
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf)
        self.shape = mi.Mesh(
            NAME, len(pairs), len(topology.faces), properties, has_vertex_normals=True, has_vertex_texcoords=True
        )
        parameters = mi.traverse(self.shape)
        parameters["faces"] = mi.UInt32(index.astype(np.uint32).ravel())
        # Row 0 of a texture is its top, v = 1; a texture without a file behind it starts at v = 0.
        uv = topology.uv[pairs[:, 1]] * [1, -1] + [0, 1]
        parameters["vertex_texcoords"] = mi.Float(uv.astype(np.float32).ravel())

    def move(self, parameters: Any, vertices: NDArray[np.float32]) -> None:
        """Take on vertex positions ``(V, 3)``; ``parameters`` are those of the scene that holds the mesh."""
        import mitsuba as mi

        normals = vertex_normals(vertices, self._topology.faces)
        parameters[f"{NAME}.vertex_positions"] = mi.Float(vertices[self._source].ravel())
        parameters[f"{NAME}.vertex_normals"] = mi.Float(normals[self._source].ravel())
        parameters.update()
