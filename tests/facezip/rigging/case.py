"""A small person whose shapes are known: a bumpy sheet, scans that mix its shapes, and a template that differs."""

from dataclasses import dataclass, replace

import numpy as np

from facezip.character.maps import KNOWN
from facezip.character.meshes import Meshes
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE
from facezip.files.obj import Topology, write_obj
from facezip.rigging.template import Template
from scenes.tiles import in_tiles
from tests.facezip.conftest import one_albedo
from tests.facezip.surfaces import slopes

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
    stack = Stack(np.rint(neutral * 255).astype(np.uint8), np.rint(textures * 255).astype(np.uint8))
    meshes = Meshes(topology, vertices.astype(np.float32), (vertices + scans).astype(np.float32))
    character = one_albedo(stack, meshes, ("frown", "grin", "smirk", "yawn"))
    template = Template(SHAPES, other.astype(np.float32), moved.astype(np.float32))
    return Case(character, template, deltas.astype(np.float32), MIXTURES)


def with_maps(scans, tiles=(1, 1)):
    """The scans with normals and roughness made of their albedo, on a grid of tiles."""
    albedo, stacks = scans.first, dict(scans.stacks)
    stacks["normal", FIRST_TILE] = Stack(slopes(albedo.neutral), slopes(albedo.textures))
    stacks["roughness", FIRST_TILE] = Stack(albedo.neutral[..., 2:].copy(), albedo.textures[..., 2:].copy())
    kinds = tuple(KNOWN[name] for name in ("albedo", "normal", "roughness"))
    return in_tiles(replace(scans, maps=kinds, stacks=stacks), *tiles)


def repeated(scans, times):
    """The scans with every texture so many times beside itself, each way: large, and made in no time."""
    stacks = {
        key: replace(stack, neutral=_tiled(stack.neutral, times), textures=_tiled(stack.textures, times))
        for key, stack in scans.stacks.items()
    }
    return replace(scans, stacks=stacks)


def write_template(case, folder):
    """The template as the files that ``facezip rig`` takes."""
    folder.mkdir()
    write_obj(folder / "neutral.obj", case.template.neutral, case.scans.meshes.topology)
    for name, delta in zip(SHAPES, case.template.deltas, strict=True):
        write_obj(folder / f"{name}.obj", case.template.neutral + delta, case.scans.meshes.topology)


def _tiled(texels, times):
    return np.tile(texels, (times, times, 1))
