"""Heads for engines to show: flat sheets that a camera sees texel by texel, in every kind of export."""

from dataclasses import replace

import numpy as np

from facezip.character.meshes import Meshes
from facezip.files.obj import Topology
from tests.facezip.conftest import grid_topology, masked, random_model
from tests.facezip.export.conftest import KINDS, grey, layered_model, smooth_model
from tests.facezip.export.gains import REGIONS, masks_in, turned

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
    "masks": head(masked(layered_model(kinds=KINDS[:4:3], tiles=(1001, 1002), slots=5, expressions=7))),
    "in blocks": of(smooth_model(meshes=False)),
    "maps in blocks": head(layered_model(smooth_model, (KINDS[0], KINDS[2], KINDS[3]))),
}


def faces_on(surface):
    """The tiles that have faces."""
    corners = surface.meshes.topology.uv[surface.meshes.topology.face_uv]
    return sorted({1001 + int(column) for column in corners.mean(axis=1)[:, 0]})


def is_mirrored(surface):
    """Whether u runs to the left: the first corner of a sheet has u = 0."""
    return surface.meshes.neutral[0, 0] > 0


def expected(surface, kind, weights):
    """All tiles of a map of a blend from left to right, ``(H, W, 3)`` float32; zeros where there is no face.

    A map of two channels has zeros for a third.
    """
    columns = [tile - 1001 for tile in faces_on(surface)]
    height, width = surface.parts["albedo", surface.tiles[0]].neutral.shape[:2]
    whole = np.zeros((height, width * (max(columns) + 1), 3), np.float32)
    for column in columns:
        place = whole[:, column * width : (column + 1) * width]
        texels = surface.blend(weights, kind.name, 1001 + column)
        place[..., : 2 if texels.shape[2] == 2 else 3] = texels
    if is_mirrored(surface):
        return whole[:, ::-1] * (np.array([-1, 1, 1], np.float32) if kind.is_normal else np.float32(1))
    return whole


def poses(expressions):
    rng = np.random.default_rng(len(expressions))
    mixed = rng.uniform(-0.5, 1, len(expressions)) / np.sqrt(len(expressions))
    return {"neutral": {}, "one": {expressions[-1]: 1.0}, "blend": dict(zip(expressions, mixed.tolist(), strict=True))}


def gains_of(surface):
    """Of a map, an expression and two regions; all others stay at 1."""
    return {
        "maps": {surface.maps[-1].name: 0.5}, "expressions": {surface.expressions[-1]: 1.5},
        "regions": {REGIONS[0]: 0.0, REGIONS[2]: 1.75},
    }  # fmt: skip


def seen_under(surface, gains, folder):
    """The surface as an export in ``folder`` shows it under gains."""
    where = {tile: folder / str(tile) if len(surface.tiles) > 1 else folder for tile in surface.tiles}
    return turned(surface, gains, {tile: masks_in(path) for tile, path in where.items()})
