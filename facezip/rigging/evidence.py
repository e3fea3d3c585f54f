"""Generated shapes by an estimator that knows the noise: empirical Bayes, place by place.

At every texel of a weight map the scans' changes are a Gaussian process over poses, of a strength ρs and with noise s
that are found there, as those under which the scans' products S are likeliest: their covariance is s (ρ K + Q). The
neutral is a scan as well, and its noise is in all changes alike: Q = 1 + 11ᵀ. A shape's maps are then their
expectation, W* = ρ k (ρ K + Q)⁻¹ W (Wiener's filter, or kriging): where scans disagree on what a shape does, or none
strains the place, ρ k is small against the noise and its change shrinks to none.

In the basis of Q⁻¹ᐟ² K Q⁻¹ᐟ² the likelihood, with s at its best, needs eigenvalues and the diagonal of S alone.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import Raster
from facezip.character.scans import Character
from facezip.machine import memory
from facezip.machine.rows import map_rows, sum_rows
from facezip.rigging.agreement import Agreement, energies
from facezip.rigging.likeness import Likeness, Poses

# How much poses that are alike as a whole may share, beside the strain of a place; one row of so many tells which.
SHARES, THINNED = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0), 4
# Of 8 bits, from the smallest to the largest weight.
STEPS = 255
# Strengths of the process over the noise that are tried; nothing besides.
STRENGTHS = (0.0, *(float(ratio) for ratio in np.geomspace(1e-3, 300, 15)))


class Filter(NamedTuple):
    """The estimator at T texels.

    Attributes
    ----------
    shares : ``(T, M, N)``, how much of every scan's weights a shape takes.
    evidence : ``(T, M)`` in [0, 1]: the part of a shape's prior variance that scans take away.
    variance : ``(T, M)``, of a shape's change before any scan was seen, in the unit of the products.
    strength : ``(T,)``, the ratio ρ.
    likelihood : ``(T,)``, the logarithm of the products' likelihood, per scan and value.
    """

    shares: NDArray[np.float64]
    evidence: NDArray[np.float64]
    variance: NDArray[np.float64]
    strength: NDArray[np.float64]
    likelihood: NDArray[np.float64]


def wiener(likeness: Likeness, products: NDArray[np.float64], least: float) -> Filter:
    """The filter of the likeliest strength and noise at every texel.

    Parameters
    ----------
    likeness : prior covariances.
    products : ``(T, N, N)``, mean products of the scans' changes.
    least : of the noise's variance, > 0.
    """
    white = _whitening(products.shape[1])
    values, vectors = np.linalg.eigh(white @ likeness.scans @ white)
    values, vectors = np.maximum(values, 0), white @ vectors
    seen = np.sum(vectors * (products @ vectors), axis=1)
    best, strength, noise = np.full(len(values), -np.inf), np.zeros(len(values)), np.full(len(values), least)
    for ratio in STRENGTHS:
        spread = ratio * values + 1
        left = (seen / spread).mean(axis=1)
        level = np.maximum(left, least)
        likelihood = -0.5 * (np.log(level) + np.log(spread).mean(axis=1) + left / level)
        better = likelihood > best
        best[better], strength[better], noise[better] = likelihood[better], ratio, level[better]
    gain = strength[:, None] / (strength[:, None] * values + 1)
    turned = likeness.between @ vectors
    shares = (turned * gain[:, None]) @ np.swapaxes(vectors, 1, 2)
    explained = (turned**2 * gain[:, None]).sum(axis=2)
    evidence = np.clip(explained / np.maximum(likeness.shapes, np.finfo(float).tiny), 0, 1)
    return Filter(shares, evidence, (noise * strength)[:, None] * likeness.shapes, strength, best)


def _whitening(count: int) -> NDArray[np.float64]:
    """Q⁻¹ᐟ² of Q = 1 + 11ᵀ, ``(N, N)``: along 1 the noise has N + 1 times the variance."""
    return np.eye(count) - (1 - 1 / np.sqrt(count + 1)) / count


@dataclass(frozen=True, eq=False)
class Estimate:
    """Maps of M shapes on a tile, and how well scans show them.

    Attributes
    ----------
    weights : ``(M, h, w, R)`` float32.
    evidence : ``(M, h, w)`` float32 in [0, 1].
    expected : ``(M, h, w)`` float32, the standard deviation of the albedo's change before any scan was seen, 0..255;
        what scans leave of its square is one less the evidence.
    strength : ``(h, w)`` float32, ρ: the changes' variance over the noise's.
    """

    weights: NDArray[np.float32]
    evidence: NDArray[np.float32]
    expected: NDArray[np.float32]
    strength: NDArray[np.float32]


def estimate(character: Character, poses: Poses, weights: Mapping[int, NDArray[np.float32]]) -> dict[int, Estimate]:
    """By tile, of the scans' weight maps ``(N, h, w, R)``; the share of ``poses.whole`` is the likeliest of all."""
    found = energies(character)
    # Over all maps, each of whose changes count one in sum.
    unit = 255 * np.sqrt(found[character.maps[0].name] / len(character.maps))
    seen = {
        tile: (
            Agreement(character, tile, maps.shape[1:3], found),
            poses.on(character.chart(tile), maps.shape[1:3]),
        )
        for tile, maps in weights.items()
    }
    best = likeliest(poses, seen.values())
    return {tile: _on_tile(*seen[tile], best, maps, float(unit)) for tile, maps in weights.items()}


def likeliest(poses: Poses, seen: Collection[tuple[Agreement, Raster]]) -> Poses:
    """The poses with that of :data:`SHARES` under which the scans' products on all tiles are likeliest."""
    choices = [replace(poses, share=share) for share in SHARES]
    likelihoods = np.sum([_likelihoods(choices, *tile) for tile in seen], axis=0)
    return choices[int(np.argmax(likelihoods))]


def _likelihoods(choices: Sequence[Poses], agreement: Agreement, raster: Raster) -> NDArray[np.float64]:
    """Of each choice over some rows of a tile: enough to tell."""

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        total = np.zeros(len(choices))
        # A row at a time: covariances of many scans take far more room than their weights.
        for row in range(top, bottom, THINNED):
            products = agreement.rows(row, row + 1)[0]
            total += [wiener(one.likeness(raster, row), products, agreement.least).likelihood.sum() for one in choices]
        return total

    return sum_rows(block, len(raster.face))


def _on_tile(agreement: Agreement, raster: Raster, poses: Poses, weights: NDArray[np.float32], unit: float) -> Estimate:
    _, height, width, slots = weights.shape
    shapes = poses.strain.shape[1] - len(weights)
    out = Estimate(
        memory.empty((shapes, height, width, slots), np.float32),
        memory.empty((shapes, height, width), np.float32),
        memory.empty((shapes, height, width), np.float32),
        memory.empty((height, width), np.float32),
    )

    def rows(top: int, bottom: int) -> None:
        for row in range(top, bottom):
            made = wiener(poses.likeness(raster, row), agreement.rows(row, row + 1)[0], agreement.least)
            out.weights[:, row] = np.einsum("tmn,ntr->mtr", made.shares, weights[:, row], optimize=True)
            out.evidence[:, row] = made.evidence.T
            out.expected[:, row] = unit * np.sqrt(made.variance.T)
            out.strength[row] = made.strength
            memory.ease()

    map_rows(rows, height)
    for slot in range(slots):
        _keep_zero(out.weights[..., slot])
    return out


def _keep_zero(weights: NDArray[np.float32]) -> None:
    """Widen the range of a slot's maps to whole steps of 8 bits on both sides of zero, which a pack then stores."""
    low, high = float(weights.min()), float(weights.max())
    if low < 0 < high:
        # At least one step is left above, where the largest weight is widened if it has less.
        steps = min(np.ceil(STEPS * -low / (high - low)), STEPS - 1)
        wide = -high * steps / (STEPS - steps)
        if wide <= low:
            weights[np.unravel_index(weights.argmin(), weights.shape)] = wide
        else:
            weights[np.unravel_index(weights.argmax(), weights.shape)] = -low * (STEPS - steps) / steps
