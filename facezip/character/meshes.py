"""The geometry of a character: one topology, and vertices for the neutral and every expression."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from facezip.files.obj import Topology


@dataclass(frozen=True, eq=False)
class Meshes:
    """Meshes that share faces and UV layout.

    Attributes
    ----------
    topology : faces and UV layout, over all tiles.
    neutral : ``(V, 3)`` float32.
    vertices : ``(N, V, 3)`` float32, absolute positions of the expressions.
    """

    topology: Topology
    neutral: NDArray[np.float32]
    vertices: NDArray[np.float32]

    @cached_property
    def deltas(self) -> NDArray[np.float32]:
        """``(N, V, 3)`` float32, expression minus neutral (equation 7)."""
        return self.vertices - self.neutral
