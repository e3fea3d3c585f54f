"""Heads for engines to show: flat sheets that a camera sees texel by texel, in every kind of export."""

from dataclasses import replace

import numpy as np

from facezip.character.meshes import Meshes
from facezip.files.obj import Topology
from tests.facezip.conftest import grid_topology, random_model
from tests.facezip.export.conftest import KINDS, grey, layered_model, smooth_model

ODD_NAMES = ("<img src=x>", "$(touch owned)", "quote \" and '", "sourire à 50 %", "a.b@c#d", "two  spaces", "眨眼")
SIZE = (24, 40)
CELLS = 3


def sheet(expressions, tiles=(1001,), empty=(), size=SIZE):
    """A sheet over the unit square of every tile but the ``empty`` ones, as wide as its textures.

    Expressions move it towards the camera, each by another distance: so none moves a pixel.
    """
    topology = grid_topology(CELLS + 1)
    columns = [tile - 1001 for tile in tiles if tile not in empty]
    corners, count = np.arange(len(columns))[:, None, None], len(topology.uv)
    uv = np.concatenate([topology.uv + np.array([column, 0], np.float32) for column in columns])
    faces = (topology.faces + corners * count).reshape(-1, 3).astype(np.int32)
    height, width = size
    vertices = np.c_[uv * np.array([width / height, 1], np.float32), np.zeros(len(uv))].astype(np.float32)
    deltas = np.zeros((expressions, *vertices.shape), np.float32)
    deltas[..., 2] = 1 + np.arange(expressions)[:, None]
    return Meshes(Topology(faces, uv, faces), vertices, vertices + deltas)


def head(surface, empty=()):
    """The same textures on a sheet."""
    size = surface.parts["albedo", surface.tiles[0]].neutral.shape[:2]
    return replace(surface, meshes=sheet(len(surface.expressions), surface.tiles, empty, size))


def named(model, names):
    return replace(model, expressions=tuple(names))


def of(model):
    return head(model)


def mirrored(surface):
    """The same with u running to the left."""
    meshes = surface.meshes
    vertices = meshes.neutral * np.array([-1, 1, 1], np.float32)
    vertices[:, 0] -= vertices[:, 0].min()
    topology = meshes.topology
    turned = Topology(topology.faces[:, ::-1].copy(), topology.uv, topology.face_uv[:, ::-1].copy())
    return replace(surface, meshes=Meshes(turned, vertices, vertices + meshes.deltas))


def faces_on(surface):
    """The tiles that have faces."""
    corners = surface.meshes.topology.uv[surface.meshes.topology.face_uv]
    return sorted({1001 + int(column) for column in corners.mean(axis=1)[:, 0]})


HEADS = {
    "one map": of(random_model(expressions=20, seed=1)),
    "one slot": of(random_model(slots=1)),
    "two layers": of(random_model(slots=5, expressions=7)),
    "uniform weights": of(random_model(weights=(1, 1))),
    "grey": of(grey(random_model())),
    "odd names": of(named(random_model(expressions=len(ODD_NAMES)), ODD_NAMES)),
    "several maps": head(layered_model(kinds=KINDS)),
    "mirrored": mirrored(head(layered_model(kinds=KINDS[:4:2]))),
    "tiles, one without faces": head(layered_model(kinds=KINDS[:4:3], tiles=(1001, 1002, 1004)), empty=(1002,)),
    "in blocks": of(smooth_model(meshes=False)),
    "maps in blocks": head(layered_model(smooth_model, (KINDS[0], KINDS[2], KINDS[3]))),
}
