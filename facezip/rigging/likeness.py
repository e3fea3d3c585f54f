"""How alike the textures of poses are expected to be, place by place, before any texture was looked at.

The change of a pose's texture at a place is taken for a Gaussian process over poses with two parts, of equal variance
for a shape: what skin does under this strain, whoever's motion it is, and what only this shape does. Poses that strain
a place alike in the same direction so share what they show of it; where a pose strains nothing, nothing is expected.
Pictures with light and shade in them change far from any strain: a third part, whose share scans themselves determine,
is what comes with poses that are alike as a whole.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import Raster, rasterise
from facezip.files.obj import Topology
from facezip.rigging.strain import strains

# Of the variance of a scan's change: what both parts leave unexplained, as skin is not linear and weights are found.
UNEXPLAINED = 0.3
# Standard deviation of the weights of shapes in scans, as they are found.
WEIGHT_ERROR = 0.2


class Likeness(NamedTuple):
    """Prior covariances at T texels, in one unit.

    Attributes
    ----------
    scans : ``(T, N, N)``, with what is unexplained of each scan on the diagonal.
    between : ``(T, M, N)``, of shapes and scans.
    shapes : ``(T, M)``, the variances of the shapes.
    """

    scans: NDArray[np.float64]
    between: NDArray[np.float64]
    shapes: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Poses:
    """Scans and shapes of one person, as strain.

    Attributes
    ----------
    strain : ``(V, N + M, 12)`` float32, scans first (:func:`facezip.rigging.strain.strains`).
    weights : ``(N, M)``, what shapes are in every scan (equation 9).
    whole : ``(N + M, N + M)``, products of all displacements, in the mean of the scans' squares.
    share : how much ``whole`` counts, everywhere alike.
    """

    strain: NDArray[np.float32]
    weights: NDArray[np.float64]
    whole: NDArray[np.float64]
    share: float = 0.0

    @classmethod
    def of(
        cls,
        neutral: NDArray[np.float32],
        scans: NDArray[np.float32],
        shapes: NDArray[np.float32],
        faces: NDArray[np.int32],
        weights: NDArray[np.float64],
    ) -> "Poses":
        """From displacements ``(N, V, 3)`` of scans and ``(M, V, 3)`` of shapes; variances are measured in the scans'.

        Without weights of shapes ``(N, 0)``, what only a shape does is left out.
        """
        found = strains(neutral, neutral + np.concatenate([scans, shapes]), faces)
        size = np.sqrt(np.mean(np.square(found[:, : len(scans)], dtype=np.float64).sum(axis=2)))
        flat = np.concatenate([scans, shapes]).reshape(len(scans) + len(shapes), -1).astype(np.float64)
        whole = flat @ flat.T
        mean = max(float(np.mean(np.diag(whole)[: len(scans)])), np.finfo(float).tiny)
        return cls(found / np.float32(max(size, np.finfo(np.float32).tiny)), weights, whole / mean)

    def on(self, topology: Topology, size: tuple[int, int]) -> Raster:
        """Where the texels of a map of ``size`` lie on the mesh; those beside the chart look at their nearest."""
        return rasterise(topology, size).dilated()

    def likeness(self, raster: Raster, row: int) -> Likeness:
        """At the texels of one row of a raster."""
        some = Raster(raster.faces, raster.face[row : row + 1], raster.barycentric[row : row + 1])
        strain = some.interpolate(self.strain)[0].astype(np.float64)
        count = len(self.weights)
        scans, shapes = strain[:, :count], strain[:, count:]
        variances = np.square(shapes).sum(axis=2)
        alone = variances if self.weights.shape[1] else np.zeros((len(strain), 0))
        own = alone[:, :, None] * self.weights.T
        believed = np.square(self.weights.T) / (np.square(self.weights.T) + WEIGHT_ERROR**2)
        whole = self.share * self.whole
        among = scans @ np.swapaxes(scans, 1, 2) + self.weights @ own + whole[:count, :count]
        among[:, range(count), range(count)] *= 1 + UNEXPLAINED
        # What a strain does is known as far as scans have strained the place: nothing is drawn out beyond.
        farthest = np.square(scans).sum(axis=2).max(axis=1)[:, None]
        within = np.sqrt(np.minimum(farthest / np.maximum(variances, np.finfo(float).tiny), 1))
        between = (within[..., None] * shapes) @ np.swapaxes(scans, 1, 2) + whole[count:, :count]
        prior = 2 * variances + np.diag(whole)[count:]
        return Likeness(among, between + believed * own if own.size else between, prior)
