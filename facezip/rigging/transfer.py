"""Deformation transfer: the shapes of one identity on another one of the same topology (Sumner and Popović 2004)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.progress import track
from facezip.rigging.frames import Integrator, edges, frames, inverse_frames


@dataclass(frozen=True, eq=False)
class Transferred:
    """A template's shapes, carried over to another neutral.

    Attributes
    ----------
    edges : ``(F, M, 3, 2)`` float32, displacement of both edge columns: M_m^A* of Li et al.
    strain : ``(F, M)`` float32, ‖(M_0 + M_m) M_0⁻¹ - 1‖ on the template: how much a shape turns or stretches
        a triangle.
    deltas : ``(M, V, 3)`` float32, the displacements that fit those edges best.
    """

    edges: NDArray[np.float32]
    strain: NDArray[np.float32]
    deltas: NDArray[np.float32]


def transfer(
    template: NDArray[np.float32], shapes: NDArray[np.float32], neutral: NDArray[np.float32], integrator: Integrator
) -> Transferred:
    """Carry ``shapes`` ``(M, V, 3)``, displacements of the vertices ``template`` ``(V, 3)``, over to ``neutral``.

    Each triangle of the neutral is turned and stretched as the template's is: M* = (M_0 + M_m) M_0⁻¹ N_0 - N_0, with
    frames M of the template and N of the neutral.
    """
    faces = integrator.faces
    source, target = edges(template, faces), edges(neutral, faces)
    inverse = inverse_frames(source)
    carried = np.empty((len(faces), len(shapes), 3, 2), np.float32)
    strain = np.empty((len(faces), len(shapes)), np.float32)
    for m, shape in enumerate(track(shapes, "Transferring the template", len(shapes))):
        gradient = (frames(source + edges(shape, faces)) - frames(source)) @ inverse
        carried[:, m] = gradient @ target
        strain[:, m] = np.linalg.norm(gradient, axis=(1, 2))
    return Transferred(carried, strain, integrator(carried, _anchors(template, shapes, neutral)))


def _anchors(
    template: NDArray[np.float32], shapes: NDArray[np.float32], neutral: NDArray[np.float32]
) -> NDArray[np.float32]:
    """The template's displacements at the size of the neutral: where parts without resting vertices go."""
    size = np.linalg.norm(np.std(neutral, axis=0)) / np.linalg.norm(np.std(template, axis=0))
    return shapes * np.float32(size)
