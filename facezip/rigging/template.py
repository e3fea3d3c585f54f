"""A template on disk: another person's shapes in the character's topology."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.mesh_names import meshes_in
from facezip.character.scans import NEUTRAL
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology, read_obj
from facezip.machine.progress import track


@dataclass(frozen=True, eq=False)
class Template:
    """Shapes to generate, on some identity.

    Attributes
    ----------
    shapes : M names, in their order.
    neutral : ``(V, 3)`` float32.
    deltas : ``(M, V, 3)`` float32, shape minus neutral.
    """

    shapes: tuple[str, ...]
    neutral: NDArray[np.float32]
    deltas: NDArray[np.float32]


def load_template(path: str | Path, topology: Topology) -> Template:
    """Read a folder with ``neutral.obj`` and ``NAME.obj`` per shape; shapes come in the order of their names.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``: no folder, neutral or shape. ``TOPOLOGY_MISMATCH``: other triangles than ``topology``'s.
        And what the reader of meshes refuses.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such folder; give the template's folder of meshes")
    meshes = meshes_in(folder).files
    names = tuple(sorted(name for name in meshes if name != NEUTRAL))
    if not names:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no shapes in it; a template has one NAME.obj per shape")
    neutral = _vertices(meshes.get(NEUTRAL, folder / f"{NEUTRAL}.obj"), topology)
    deltas = np.empty((len(names), *neutral.shape), np.float32)
    for m, name in enumerate(track(names, "Reading the template", len(names))):
        vertices = _vertices(meshes[name], topology)
        if vertices.shape != neutral.shape:
            raise _other_topology(meshes[name], f"{len(vertices)} vertices, its neutral has {len(neutral)}")
        deltas[m] = vertices - neutral
    return Template(names, neutral, deltas)


def _vertices(path: Path, topology: Topology) -> NDArray[np.float32]:
    vertices, found = read_obj(path)
    if not np.array_equal(found.faces, topology.faces):
        counts = f"{len(found.faces)} triangles, the character has {len(topology.faces)}, in its order"
        raise _other_topology(path, counts)
    return vertices


def _other_topology(path: Path, difference: str) -> FaceZipError:
    return FaceZipError(ErrorCode.TOPOLOGY_MISMATCH, f"{path}: {difference}; wrap the template to the scans' mesh")
