"""Textures on the head from the front, without a renderer: pictures that only have to say where something is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import vertex_normals
from facezip.character.meshes import Meshes
from facezip.character.raster import rasterise
from facezip.character.tiles import Atlas
from facezip.files.obj import Topology
from reports.images import BACKDROP, to_bytes

# Pixels of a picture are means of so many each way.
FINER = 2
MARGIN = 0.04
# Towards the light, from the camera's left and above; and how bright a face is that looks away from it.
LIGHT = np.array([-0.35, 0.45, 0.82], np.float32)
AMBIENT = np.float32(0.55)


@dataclass(frozen=True, eq=False)
class Sight:
    """Where each of ``(h, w)`` finer pixels looks.

    Attributes
    ----------
    uv : ``(h, w, 2)`` in the unit square of all tiles, v up.
    light : ``(h, w)`` float32, how bright a white surface is there; 0 where nothing is.
    """

    uv: NDArray[np.float32]
    light: NDArray[np.float32]

    @classmethod
    def of_chart(cls, side: int) -> "Sight":
        """The textures themselves, for packs without a mesh."""
        line = (np.arange(side * FINER, dtype=np.float32) + np.float32(0.5)) / np.float32(side * FINER)
        u, v = np.meshgrid(line, 1 - line)
        return cls(np.stack([u, v], axis=2), np.ones_like(u))

    @classmethod
    def of_head(cls, meshes: Meshes, vertices: NDArray[np.float32], atlas: Atlas, side: int) -> "Sight":
        """A head of ``vertices`` ``(V, 3)`` from the front, at a scale in which its neutral is ``side`` pixels high."""
        low, high = meshes.neutral.min(axis=0)[:2], meshes.neutral.max(axis=0)[:2]
        extent = (1 + 2 * MARGIN) * float((high - low).max())
        size = side * FINER, max(int(side * FINER * min((high - low)[0] / extent + 2 * MARGIN, 1.0)), 1)
        span = np.array([extent * size[1] / size[0], extent])
        screen = ((vertices[:, :2] - (low + high) / 2) / span + 0.5).astype(np.float32)
        layout = atlas.topology(meshes.topology)
        corners = layout.uv[layout.face_uv]
        # From back to front, since the last triangle wins.
        order = np.argsort(vertices[layout.faces, 2].mean(axis=1), kind="stable")
        faces = layout.faces[order]
        raster = rasterise(Topology(faces, screen, faces), size)
        seen = np.maximum(raster.face, 0)
        uv = np.einsum("hwj,hwjc->hwc", raster.barycentric, corners[order][seen])
        normals = raster.interpolate(vertex_normals(vertices, meshes.topology.faces).astype(np.float32))
        towards = np.maximum(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0)
        return cls(uv, np.where(raster.covered, AMBIENT + (1 - AMBIENT) * towards, 0).astype(np.float32))

    def picture(self, texture: NDArray[np.float32], shaded: bool = True) -> NDArray[np.uint8]:
        """A texture ``(H, W, 3)`` of encoded values on the backdrop, ``(h, w, 3)``."""
        height, width, _ = texture.shape
        rows = np.clip(((1 - self.uv[..., 1]) * height).astype(int), 0, height - 1)
        columns = np.clip((self.uv[..., 0] * width).astype(int), 0, width - 1)
        colours = texture[rows, columns] * (self.light[..., None] if shaded else np.float32(1))
        backdrop = np.array(BACKDROP, np.float32) / np.float32(255)
        whole = np.where(self.light[..., None] > 0, colours, backdrop)
        h, w = (length // FINER for length in self.light.shape)
        cells = whole[: h * FINER, : w * FINER].reshape(h, FINER, w, FINER, 3)
        return to_bytes(cells.mean(axis=(1, 3), dtype=np.float32))
