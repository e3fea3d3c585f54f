"""A small person whose shapes are known: a bumpy sheet, scans that mix its shapes, and a template that differs."""

from dataclasses import dataclass

import numpy as np

from facezip.character.scans import Character
from facezip.files.obj import Topology
from facezip.rigging.template import Template

SIDE = 24
SHAPES = ("brow", "cheekLeft", "cheekRight", "jaw", "tongue")
# The tongue is in no scan.
MIXTURES = np.array([[1, 0, 0, 0, 0], [0, 0.9, 0.8, 0, 0], [0, 0.7, 0, 0.6, 0], [0.5, 0, 0, 1, 0]], float)


@dataclass(frozen=True, eq=False)
class Case:
    scans: Character
    template: Template
    deltas: np.ndarray
    weights: np.ndarray


def sheet():
    line = np.linspace(-1, 1, SIDE)
    y, x = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x, y, 0.3 * np.cos(2 * x) * np.cos(y)], axis=2).reshape(-1, 3)
    cell = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    faces = np.concatenate(
        [np.stack([cell, cell + 1, cell + SIDE + 1], 1), np.stack([cell, cell + SIDE + 1, cell + SIDE], 1)]
    )
    uv = (np.stack([x, y], axis=2).reshape(-1, 2) + 1) / 2
    return vertices, Topology(faces.astype(np.int32), uv.astype(np.float32), faces.astype(np.int32))


def bump(vertices, centre, move):
    reach = np.exp(-np.sum(((vertices[:, :2] - centre) / 0.35) ** 2, axis=1))
    return np.where(reach < 1e-3, 0, reach)[:, None] * np.array(move)


def shapes(vertices):
    places = [(0, 0.6), (0.5, 0), (-0.5, 0), (0, -0.6), (0, 0)]
    moves = [(0, 0.2, 0.1), (0.1, 0.15, 0), (-0.1, 0.15, 0), (0, -0.3, 0.1), (0, 0, 0.3)]
    return np.stack([bump(vertices, *pair) for pair in zip(places, moves, strict=True)])


def make_case(side=64, seed=0):
    rng = np.random.default_rng(seed)
    vertices, topology = sheet()
    deltas = shapes(vertices)
    other = vertices * [1.2, 0.9, 1.5] + [3, 0, 0]
    strength = 1 + 0.2 * rng.standard_normal(len(deltas))
    moved = deltas * [1.2, 0.9, 1.5] * strength[:, None, None]
    scans = np.tensordot(MIXTURES, deltas, 1)
    neutral = rng.uniform(0.3, 0.7, (side, side, 3)).astype(np.float32)
    textures = np.clip(neutral + 0.1 * rng.standard_normal((len(MIXTURES), side, side, 3)), 0, 1)
    character = Character(
        "sheet",
        topology,
        ("frown", "grin", "smirk", "yawn"),
        vertices.astype(np.float32),
        (vertices + scans).astype(np.float32),
        np.rint(neutral * 255).astype(np.uint8),
        np.rint(textures * 255).astype(np.uint8),
    )
    template = Template(SHAPES, other.astype(np.float32), moved.astype(np.float32))
    return Case(character, template, deltas.astype(np.float32), MIXTURES)
