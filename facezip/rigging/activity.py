"""Where shapes act: how far each of them moves the surface around every texel of a weight map."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character.raster import rasterise
from facezip.files.obj import Topology
from facezip.machine import memory

# Texels of a weight map over which activity is smoothed: wrinkles reach beyond the motion that makes them.
BLUR = 1.0


def activity(topology: Topology, deltas: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """Length of the displacements ``(M, V, 3)`` at texel centres, ``(h, w, M)`` float32 in the mesh's unit, smoothed.

    Texels beside the chart take their nearest neighbour's.
    """
    chart = rasterise(topology, size).dilated()
    smooth: NDArray[np.float32] = memory.empty((*size, len(deltas)), np.float32)
    for m, delta in enumerate(deltas):
        smooth[..., m] = gaussian_filter(chart.interpolate(np.linalg.norm(delta, axis=1)), BLUR, mode="nearest")
        memory.ease()
    return smooth
