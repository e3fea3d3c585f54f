"""Where the scene of a glTF shows a mesh: the transforms of its nodes, or the joints that its vertices hang on."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb

NEAR = 1e-6
# In which a face can still be measured.
SMALLEST, LARGEST = 1e-12, 1e12


class Nodes:
    """The nodes of a file."""

    def __init__(self, glb: Glb) -> None:
        self._glb = glb
        self._nodes = [glb.item("nodes", index) for index in range(len(glb.document.get("nodes", [])))]
        self._parents = {child: index for index, node in enumerate(self._nodes) for child in node.get("children", [])}

    def showing(self, mesh: int) -> list[int]:
        """The nodes that show a mesh, those of the scene that is shown first."""
        found = [index for index, node in enumerate(self._nodes) if node.get("mesh") == mesh]
        scenes = self._glb.document.get("scenes", [])
        shown = scenes[self._glb.document.get("scene", 0)].get("nodes", []) if scenes else []
        return sorted(found, key=lambda index: self._path(index)[-1] not in shown)

    def names(self, mesh: int) -> list[str]:
        """What the nodes that show a mesh are called."""
        return [str(self._nodes[index]["name"]) for index in self.showing(mesh) if self._nodes[index].get("name")]

    def placements(self, mesh: int, primitive: GltfObject, count: int) -> NDArray[np.float64]:
        """``(3, 4)`` that places the vertices of a primitive, or ``(count, 3, 4)``, one for each.

        A mesh with a skin is where its joints hold it, wherever its own node is (glTF 2.0, section 3.7.3.3).
        """
        nodes = self.showing(mesh)
        if not nodes:
            return np.eye(4)[:3]
        skin = self._nodes[nodes[0]].get("skin")
        matrix = self._world(nodes[0]) if skin is None else self._held(self._glb.item("skins", skin), primitive, count)
        return _checked(matrix[..., :3, :])

    def _path(self, node: int) -> list[int]:
        """A node and those above it; the last has none."""
        path = [node]
        while (parent := self._parents.get(path[-1])) is not None and parent not in path:
            path.append(parent)
        return path

    def _world(self, node: int) -> NDArray[np.float64]:
        total = np.eye(4)
        with np.errstate(all="ignore"):
            for index in self._path(node):
                total = _local(self._nodes[index]) @ total
        return total

    def _held(self, skin: GltfObject, primitive: GltfObject, count: int) -> NDArray[np.float64]:
        joints = [self._world(joint) for joint in skin["joints"] if self._glb.item("nodes", joint) is not None]
        binds = np.tile(np.eye(4), (len(joints), 1, 1))
        if "inverseBindMatrices" in skin:
            binds = self._glb.array(skin["inverseBindMatrices"]).astype(np.float64).reshape(-1, 4, 4).swapaxes(1, 2)
        if len(binds) < len(joints) or not joints:
            raise GlbFault("its skin has joints without bind matrices; export it again")
        places = np.array(joints) @ binds[: len(joints)]
        numbers, weights = (self._influences(primitive, kind, count) for kind in ("JOINTS", "WEIGHTS"))
        if numbers.shape != weights.shape or numbers.max(initial=0) >= len(places):
            raise GlbFault("its skin has other joints than its vertices name; export it again")
        used = places[np.unique(numbers[weights > 0]).astype(np.intp)]
        if len(used) and np.allclose(used, used[0], rtol=0, atol=NEAR * max(1, np.abs(used[0]).max())):
            return np.asarray(used[0], np.float64)
        return sum_of(places, numbers.astype(np.intp), weights)

    def _influences(self, primitive: GltfObject, kind: str, count: int) -> NDArray[Any]:
        attributes, found = primitive["attributes"], list[NDArray[Any]]()
        while f"{kind}_{len(found)}" in attributes:
            found.append(self._glb.array(attributes[f"{kind}_{len(found)}"]))
        if not found or any(values.shape != (count, 4) for values in found):
            raise GlbFault(f"its skin needs {kind}_0 of four numbers a vertex; export it again")
        return np.concatenate(found, axis=1)


def sum_of(places: NDArray[np.float64], numbers: NDArray[np.intp], weights: NDArray[np.float32]) -> NDArray[np.float64]:
    """``(V, 4, 4)``: the matrices ``(J, 4, 4)`` of the joints ``(V, K)`` of each vertex, by their weights."""
    total = weights.sum(axis=1, dtype=np.float64)
    if not (total > NEAR).all():
        raise GlbFault("its skin has vertices that hang on no joint; export it again")
    shares = weights / total[:, None]
    # Joint by joint, not as one product: copies of a vertex come out alike to the last bit.
    held = np.zeros((len(numbers), 4, 4))
    for k in range(numbers.shape[1]):
        held += shares[:, k, None, None] * places[numbers[:, k]]
    return held


def placed(points: NDArray[Any], matrix: NDArray[np.float64]) -> NDArray[np.float32]:
    """Points ``(V, 3)``, moved by ``(3, 4)`` or ``(V, 3, 4)``; those that are equal stay so."""
    x, y, z = (points[:, axis, None].astype(np.float64) for axis in range(3))
    moved = x * matrix[..., 0] + y * matrix[..., 1] + z * matrix[..., 2] + matrix[..., 3]
    return moved.astype(np.float32)


def leaves_alone(matrix: NDArray[np.float64]) -> bool:
    """Whether a transform is none, but for rounding."""
    return bool(np.allclose(matrix, np.eye(4)[:3], rtol=0, atol=NEAR))


def is_mirror(matrix: NDArray[np.float64]) -> bool:
    """Whether a transform turns triangles over."""
    return bool((np.linalg.det(matrix[..., :3]) < 0).any())


def described(matrix: NDArray[np.float64]) -> str:
    """What a transform does, in words."""
    if matrix.ndim == 3:
        return "posed by its joints"
    lengths = np.linalg.norm(matrix[:, :3], axis=0)
    axes = matrix[:, :3] / lengths
    done = {
        "mirrored": is_mirror(matrix),
        "turned": not np.allclose(np.abs(axes) if is_mirror(matrix) else axes, np.eye(3), rtol=0, atol=NEAR),
        "scaled": not np.allclose(lengths, 1, rtol=0, atol=NEAR),
        "moved": bool(np.abs(matrix[:, 3]).max() > NEAR),
    }
    words = [word for word, holds in done.items() if holds]
    return f"{_listed(words)} as its nodes say"


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _checked(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(all="ignore"):
        size = np.cbrt(np.abs(np.linalg.det(matrix[..., :3])))
    if not ((size > SMALLEST) & (size < LARGEST)).all() or not (np.abs(matrix) < LARGEST).all():
        raise GlbFault("its node has a transform that flattens it or is no number; export it again")
    return matrix


def _local(node: GltfObject) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), float)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    local = np.eye(4)
    local[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), float)
    local[:3, 3] = np.array(node.get("translation", (0, 0, 0)), float)
    return local
