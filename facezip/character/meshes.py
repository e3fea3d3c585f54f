"""The geometry of a character: one topology, and vertices for the neutral and every expression."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology, used_rows

# Of the head's size: what rounding to float32 may move a vertex by. Half a hundredth of a millimetre.
ROUNDING = 2e-5


@dataclass(frozen=True, eq=False)
class Meshes:
    """Meshes that share faces and UV layout.

    Attributes
    ----------
    topology : faces and UV layout, over all tiles.
    neutral : ``(V, 3)`` float32.
    vertices : ``(N, V, 3)`` float32, absolute positions of the expressions.
    centimetres : whether these are known to be centimetres; of other numbers the unit is not known.
    """

    topology: Topology
    neutral: NDArray[np.float32]
    vertices: NDArray[np.float32]
    centimetres: bool = False

    @cached_property
    def deltas(self) -> NDArray[np.float32]:
        """``(N, V, 3)`` float32, expression minus neutral (equation 7)."""
        return self.vertices - self.neutral


def check_digits(path: Path, vertices: NDArray[np.float32], topology: Topology) -> None:
    """Raise ``UNREADABLE_MESH`` where a mesh ``(V, 3)`` lies so far away that rounding moves the vertices of its faces.

    Map coordinates are millions of units: of a head's millimetres nothing is left there in a float32.
    """
    used = used_rows(vertices, topology.faces)
    size, farthest = float(np.ptp(used, axis=0).max()), np.abs(used).max()
    step = float(np.spacing(farthest))
    if farthest > 0 and step > ROUNDING * size:
        raise FaceZipError(
            ErrorCode.UNREADABLE_MESH,
            f"{path}: {size:.3g} units in size and up to {farthest:.3g} from the origin, where numbers are {step:.2g} "
            "apart; move the meshes to the origin before they are exported",
        )
