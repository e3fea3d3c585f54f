"""Each scan's texture predicted from all others, through what the meshes strain: evidence where there is no truth.

python -m tests.facezip.rigging.left_out ../shared/data/capture_a
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip.character.loading import load_character
from facezip.character.scans import Character
from facezip.cleaning.steps import clean
from facezip.files.images import to_float
from facezip.rigging.agreement import Agreement, energies
from facezip.rigging.evidence import likeliest, wiener
from facezip.rigging.likeness import Poses

SCALE = 8


def shares_without(scans: Character, left: int) -> np.ndarray:
    """``(h, w, N)``: what of every scan's difference the estimator takes for the one left out, 0 of itself."""
    others = np.delete(np.arange(len(scans.expressions)), left)
    meshes, key = scans.meshes, (scans.maps[0].name, scans.tiles[0])
    rest = _some(scans, others)
    poses = Poses.of(
        meshes.neutral,
        meshes.deltas[others],
        meshes.deltas[left : left + 1],
        meshes.topology.faces,
        np.zeros((len(others), 0)),
    )
    height, width = (size // SCALE for size in scans.first.resolution)
    agreement = Agreement(rest, key[1], (height, width), energies(rest))
    raster = poses.on(scans.chart(key[1]), (height, width))
    poses = likeliest(poses, [(agreement, raster)])
    products = agreement.rows(0, height)
    shares = np.zeros((height, width, len(scans.expressions)))
    for row in range(height):
        shares[row][:, others] = wiener(poses.likeness(raster, row), products[row], agreement.least).shares[:, 0]
    return shares


def naive_without(scans: Character, left: int) -> np.ndarray:
    """``(N,)``: the weights with which the other meshes make this one in least squares, as B⁺ would, 0 of itself."""
    flat = scans.meshes.deltas.reshape(len(scans.expressions), -1).astype(float)
    others = np.delete(np.arange(len(flat)), left)
    weights = np.zeros(len(flat))
    weights[others] = np.linalg.lstsq(flat[others].T, flat[left], rcond=1e-2)[0]
    return weights


def errors(scans: Character, left: int) -> tuple[float, float, float]:
    """RMSE, 0..255 inside the mask, of our prediction, of the neutral and of the naive sum."""
    stack = scans.first
    neutral = to_float(stack.neutral)
    changes = to_float(stack.textures) - neutral
    shares = np.kron(shares_without(scans, left), np.ones((SCALE, SCALE, 1)))
    ours = np.einsum("yxn,nyxc->yxc", shares, changes)
    naive = np.tensordot(naive_without(scans, left), changes, 1)

    def rmse(prediction: np.ndarray) -> float:
        squares = np.square(np.clip(neutral + prediction, 0, 1) - neutral - changes[left]).mean(axis=2)
        return float(255 * np.sqrt(np.average(squares, weights=stack.weight)))

    return rmse(ours), rmse(np.zeros_like(ours)), rmse(naive)


def _some(scans: Character, order: np.ndarray) -> Character:
    stacks = {key: replace(stack, textures=stack.textures[order]) for key, stack in scans.stacks.items()}
    meshes = replace(scans.meshes, vertices=scans.meshes.vertices[order])
    return replace(scans, expressions=tuple(scans.expressions[n] for n in order), meshes=meshes, stacks=stacks)


if __name__ == "__main__":
    character = clean(load_character(Path(sys.argv[1])), sys.argv[2:]).character
    found = np.array([errors(character, n) for n in range(len(character.expressions))])
    print(f"{'left out':12} {'ours':>7} {'neutral':>8} {'naive':>7}")
    for expression, row in zip(character.expressions, found, strict=True):
        print(f"{expression:12} {row[0]:7.2f} {row[1]:8.2f} {row[2]:7.2f}")
    print(f"{'mean':12} {found[:, 0].mean():7.2f} {found[:, 1].mean():8.2f} {found[:, 2].mean():7.2f}")
    print(f"worse than the neutral: {int((found[:, 0] > found[:, 1]).sum())} of {len(found)}")
