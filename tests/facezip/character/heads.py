"""Heads for laws on geometry: the embedded character's and other people's, as wholes and as masks of the face."""

from functools import cache

import numpy as np

from facezip.character.meshes import Meshes
from facezip.files.obj import Topology
from scenes.face.expressions import EXPRESSIONS
from scenes.face.head import build_head
from scenes.face.shapes import ARKIT_SHAPES, shape_deltas
from scenes.template import another_identity


@cache
def head(person=0, mask=False):
    """A person with some of the embedded character's expressions; person 0 is that one. A mask is the face alone."""
    built = build_head()
    neutral, shapes = built.vertices, shape_deltas(built)
    if person:
        neutral, shapes = another_identity(neutral, shapes, person)
    some = list(EXPRESSIONS.values())[:6]
    weights = np.array([[one.get(name, 0.0) for name in ARKIT_SHAPES] for one in some], np.float32)
    meshes = Meshes(built.topology, neutral, neutral + np.tensordot(weights, shapes, 1).astype(np.float32))
    return only(meshes, (neutral[:, 2] > 1.5) & (neutral[:, 1] > -11)) if mask else meshes


def only(meshes, kept):
    """The triangles all of whose vertices are kept."""
    here = kept[meshes.topology.faces].all(axis=1)
    used, faces = np.unique(meshes.topology.faces[here], return_inverse=True)
    topology = Topology(faces.reshape(-1, 3).astype(np.int32), meshes.topology.uv, meshes.topology.face_uv[here])
    return Meshes(topology, meshes.neutral[used], meshes.vertices[:, used])


def moved(meshes, matrix, shift=(0, 0, 0)):
    """All meshes, each point p at ``matrix p + shift``."""

    def changed(vertices):
        return (vertices.astype(np.float64) @ np.asarray(matrix, float).T + shift).astype(np.float32)

    return Meshes(meshes.topology, changed(meshes.neutral), changed(meshes.vertices))


def with_expression(meshes, n, vertices):
    """The meshes with one expression's vertices replaced."""
    changed = meshes.vertices.copy()
    changed[n] = vertices
    return Meshes(meshes.topology, meshes.neutral, changed)
