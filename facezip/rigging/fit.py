"""Example-based facial rigging (Li, Weise and Pauly 2010): a few scans and a template become a person's own shapes.

Two steps alternate. Weights fixed, the shapes are found triangle by triangle (step A) and integrated to vertices;
shapes fixed, the weights of every scan are a small box-constrained problem (step B). The template counts less, and the
first weights bind less, from step to step.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.machine import memory
from facezip.machine.progress import track
from facezip.rigging.frames import Integrator, edges
from facezip.rigging.poses import pose_weights
from facezip.rigging.shapes import explain
from facezip.rigging.transfer import transfer
from facezip.rigging.weightmaps import Examples

ALTERNATIONS = 5
# From the first alternation to the last: how much the template counts (β of the paper), and how firmly weights are
# held to their first values (its γ, in units of a shape's own squared norm).
BETA = (0.5, 0.1)
PULL = (1.0, 0.3)
# What counts as much motion of a vertex, as a part of the largest of its shape, and as much strain of a triangle: the
# paper's weights depend on the unit of the mesh, these on none.
UNITS = (0.3, 0.3)
# A face shows few shapes at a time: those with less weight than this are left out of the first values.
SPARSITY = 0.01
# Scans show a shape of which they determine at least this part.
SEEN = 0.1
# Copies of both edges of every triangle of every shape and scan, in single precision, that the fit holds at most.
COPIES = 6
# A vertex rests where nothing moves it by more than this part of the largest displacement.
STILL = 1e-4


@dataclass(frozen=True, eq=False)
class Rig:
    """Shapes that a person was given, and what every scan is made of (equation 9).

    Attributes
    ----------
    deltas : ``(M, V, 3)`` float32, V*_m - V_0.
    weights : ``(N, M)`` float64 in [0, 1], β̄: scan n is Σ_m β̄_nm of the shapes.
    transferred : ``(M, V, 3)`` float32, the template's shapes on this neutral, before any scan was looked at.
    residuals : ``(N,)`` root mean square over vertices of what equation (9) leaves, in the mesh's unit.
    """

    deltas: NDArray[np.float32]
    weights: NDArray[np.float64]
    transferred: NDArray[np.float32]
    residuals: NDArray[np.float64]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """``(M,)``: the shapes that scans show; the others keep, nearly, the template's motion."""
        return self.determined >= SEEN

    @property
    def determined(self) -> NDArray[np.float64]:
        """``(M,)`` in [0, 1], diag(B⁺B): how much of a shape the scans tell apart from all others."""
        examples = Examples.of(self.weights)
        shares: NDArray[np.float64] = np.sum(examples.inverse * (examples.mixtures.T @ examples.weights).T, axis=1)
        return shares


def fit_rig(
    neutral: NDArray[np.float32],
    scans: NDArray[np.float32],
    faces: NDArray[np.int32],
    template: NDArray[np.float32],
    shapes: NDArray[np.float32],
) -> Rig:
    """The shapes of the person whose neutral and scans these are.

    Parameters
    ----------
    neutral : ``(V, 3)`` vertices.
    scans : ``(N, V, 3)``, displacements of the neutral.
    faces : ``(F, 3)``.
    template : ``(V, 3)``, another neutral of the same topology.
    shapes : ``(M, V, 3)``, displacements of the template.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a limit of memory in which meshes, which are held whole, have no room.
    """
    memory.check(0, COPIES * 6 * np.dtype(np.float32).itemsize * len(faces) * (len(scans) + len(shapes)))
    integrator = Integrator(faces, _resting(scans, shapes))
    start = transfer(template, shapes, neutral, integrator)
    prior, moved = _by_vertices(start.deltas), _by_vertices(scans)
    reach = np.linalg.norm(prior, axis=2)
    reach /= np.maximum(reach.max(axis=0), np.finfo(np.float32).tiny) * np.float32(UNITS[0])
    strain = start.strain / np.float32(UNITS[1])
    sides, scan_sides = _flat(start.edges), _flat(np.moveaxis(edges(scans, faces), 0, 1))
    guess = weights = pose_weights(start.deltas, scans, sparsity=SPARSITY)
    schedule = zip(np.geomspace(*BETA, ALTERNATIONS), np.geomspace(*PULL, ALTERNATIONS), strict=True)
    for beta, pull in track(schedule, "Rigging", ALTERNATIONS):
        places = explain(prior, reach, moved, weights, beta)
        turned = explain(sides, strain, scan_sides, weights, beta)
        deltas = integrator(turned.reshape(start.edges.shape), np.moveaxis(places, 1, 0))
        weights = pose_weights(deltas, scans, guess, pull)
    return Rig(deltas, weights, start.deltas, _residuals(deltas, weights, scans))


def _by_vertices(displacements: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(V, M, 3)`` of ``(M, V, 3)``."""
    return np.ascontiguousarray(np.moveaxis(displacements, 1, 0))


def _flat(columns: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """Both edge columns as one, ``(F, M, 6)``."""
    return np.ascontiguousarray(columns.reshape(*columns.shape[:2], 6), np.float32)


def _resting(scans: NDArray[np.float32], shapes: NDArray[np.float32]) -> NDArray[np.bool_]:
    moved = [np.linalg.norm(values, axis=2).max(axis=0) for values in (scans, shapes)]
    still: NDArray[np.bool_] = np.logical_and.reduce([reach <= STILL * reach.max() for reach in moved])
    return still


def _residuals(
    deltas: NDArray[np.float32], weights: NDArray[np.float64], scans: NDArray[np.float32]
) -> NDArray[np.float64]:
    gap = scans - np.tensordot(weights.astype(np.float32), deltas, 1)
    left: NDArray[np.float64] = np.sqrt(np.mean(np.sum(np.square(gap, dtype=np.float64), axis=2), axis=1))
    return left
