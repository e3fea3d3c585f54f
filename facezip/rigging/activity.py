"""Where shapes act: how far each of them moves the surface around every texel of a weight map."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character.raster import rasterise
from facezip.files.obj import Topology

# Texels of a weight map over which activity is smoothed: wrinkles reach beyond the motion that makes them.
BLUR = 1.0


def activity(topology: Topology, deltas: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """Length of the displacements ``(M, V, 3)`` at texel centres, ``(h, w, M)`` float32 in the mesh's unit, smoothed.

    Texels beside the chart take their nearest neighbour's.
    """
    reach = np.ascontiguousarray(np.linalg.norm(deltas, axis=2).T)
    maps = rasterise(topology, size).dilated().interpolate(reach)
    smooth: NDArray[np.float32] = gaussian_filter(maps, (BLUR, BLUR, 0), mode="nearest")
    return smooth
