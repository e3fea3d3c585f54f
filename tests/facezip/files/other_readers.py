"""OBJ by others: triangles ``(F, 3, 5)`` as positions and UVs of their corners."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import tinyobjloader
import trimesh

from facezip.files.obj import Topology
from tests.facezip.files.spellings import forwards, plain


def by_tinyobjloader(path: Path) -> np.ndarray:
    """In the order of the file; by parsing of its own, which rounds."""
    reader, settings = tinyobjloader.ObjReader(), tinyobjloader.ObjReaderConfig()
    settings.triangulate = False
    if not reader.ParseFromFile(str(path), settings):
        raise ValueError(reader.Error())
    attributes = reader.GetAttrib()
    # Its arrays hold zeros beside numpy 2.
    vertices = np.array(attributes.vertices).reshape(-1, 3)
    uv = np.array(attributes.texcoords).reshape(-1, 2)
    triangles = []
    for shape in reader.GetShapes():
        corners = iter([(c.vertex_index, c.texcoord_index) for c in shape.mesh.indices])
        for count in shape.mesh.num_face_vertices:
            polygon = [next(corners) for _ in range(count)]
            triangles += [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, count - 1)]
    indices = np.array(triangles)
    if (indices < 0).any():
        raise ValueError("a corner without a UV")
    return np.concatenate([vertices[indices[:, :, 0]], uv[indices[:, :, 1]]], axis=2)


def by_trimesh(path: Path) -> np.ndarray:
    """By the number of corners and by material; indices from the end would count from that of the file."""
    path.write_bytes(forwards(path.read_bytes()))
    parts = trimesh.load_scene(path, process=False, skip_materials=True, group_material=False).geometry.values()
    return np.concatenate([np.concatenate([part.vertices, part.visual.uv], axis=1)[part.faces] for part in parts])


READERS: tuple[Callable[[Path], np.ndarray], ...] = (by_tinyobjloader, by_trimesh)


def disagreements(text: bytes, place: Path, vertices: np.ndarray, topology: Topology) -> list[str]:
    """The readers that read other triangles than these from an OBJ file's text, or none; ``place`` for a file."""
    mine = np.concatenate([vertices[topology.faces], topology.uv[topology.face_uv]], axis=2)
    place.write_bytes(plain(text))
    return [reader.__name__ for reader in READERS if not _agrees(reader, place, mine)]


def _agrees(reader: Callable[[Path], np.ndarray], path: Path, mine: np.ndarray) -> bool:
    try:
        theirs = reader(path)
    except Exception:
        return False
    if theirs.shape != mine.shape:
        return False
    if reader is not by_tinyobjloader:
        mine, theirs = _sorted(mine), _sorted(theirs)
    return np.allclose(mine, theirs, rtol=1e-5, atol=1e-6)


def _sorted(triangles: np.ndarray) -> np.ndarray:
    """In an order, and from a corner, that do not depend on the reader."""
    rows = triangles.astype(np.float32).tolist()
    return np.array(sorted(min(row[k:] + row[:k] for k in range(3)) for row in rows))
