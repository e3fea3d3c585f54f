import numpy as np
import pytest

from facezip.character.maps import KNOWN
from facezip.character.meshes import Meshes
from facezip.character.scans import Character, Stack
from facezip.files.obj import Topology
from render.paired import PairedRenderer
from scenes.cameras import frame_of


def lumpy_head(side=24):
    """A closed, lumpy ball with one UV chart: enough of a head for light and camera."""
    v, u = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side), indexing="ij")
    polar, azimuth = np.pi * (1 - v), 2 * np.pi * (u - 0.5)
    radius = 10 + 0.6 * np.sin(5 * azimuth) * np.sin(polar) ** 2
    ball = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)], 2)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + side + 1], 1), np.stack([corner, corner + side + 1, corner + side], 1)]
    ).astype(np.int32)
    topology = Topology(faces, np.stack([u, v], 2).reshape(-1, 2).astype(np.float32), faces)
    return (radius[..., None] * ball).reshape(-1, 3).astype(np.float32), topology


@pytest.fixture(scope="session")
def head():
    return lumpy_head()


@pytest.fixture(scope="session")
def renderer(head):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio", "daylight", "side"], "skin", 64)
    renderer.pose(vertices)
    return renderer


@pytest.fixture(scope="session")
def texture():
    rng = np.random.default_rng(0)
    smooth = np.kron(rng.random((8, 8, 3)), np.ones((8, 8, 1)))
    return (0.2 + 0.6 * smooth).astype(np.float32)


@pytest.fixture(scope="session")
def character(head, texture):
    vertices, topology = head
    rng = np.random.default_rng(1)
    textures = np.clip(texture + rng.normal(0, 0.05, (2, *texture.shape)), 0, 1)
    meshes = Meshes(topology, vertices, np.stack([vertices * 1.01, vertices * 0.99]).astype(np.float32))
    stack = Stack(np.rint(texture * 255).astype(np.uint8), np.rint(textures * 255).astype(np.uint8))
    return Character("ball", ("smile", "frown"), meshes, (KNOWN["albedo"],), {("albedo", 1001): stack})
