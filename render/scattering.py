"""How far light scatters in the skin, and the normals that its diffuse light follows."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, zoom

from facezip.character.maps import LEAST_DIVISOR
from facezip.files.obj import Topology

# Standard deviation by which red, green and blue irradiance is blurred, in heights of a head with its neck. Of 30 cm:
# 1.8, 0.8 and 0.5 mm. Skin's profiles are sums of Gaussians of such widths, and red has a longer tail:
# d'Eon and Luebke, "Advanced Techniques for Realistic Real-Time Skin Rendering" (2007).
WIDTHS = (0.0060, 0.0027, 0.0017)
# Blurred normals need no more texels than this a side.
MOST = 1024


def spread(topology: Topology, vertices: NDArray[np.float32]) -> float:
    """How many sides of the UV square a head's height covers on it, on average over its surface."""
    a, b, c = vertices.astype(np.float64)[topology.faces].transpose(1, 0, 2)
    surface = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    a, b, c = topology.uv.astype(np.float64)[topology.face_uv].transpose(1, 0, 2)
    chart = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
    return float(np.sqrt(chart / surface) * np.ptp(vertices[:, 1]))


def blurred_slopes(normal: NDArray[np.float32], height: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Slopes x/z and y/z ``(h, w, 3)`` that red, green and blue light follows, at most :data:`MOST` texels a side.

    Parameters
    ----------
    normal : ``(H, W, 3)`` unit vectors.
    height : of the head, in sides of the UV square, of :func:`spread`.
    """
    slopes = normal[..., :2] / np.maximum(normal[..., 2:], LEAST_DIVISOR)
    size = min(1.0, MOST / max(slopes.shape[:2]))
    if size < 1:
        slopes = zoom(
            gaussian_filter(slopes, (0.4 / size, 0.4 / size, 0)),
            (size, size, 1),
            order=1,
            grid_mode=True,
            mode="nearest",
        )
    rows, columns = slopes.shape[:2]
    by_channel = [
        gaussian_filter(slopes, (width * height * rows, width * height * columns, 0), mode="nearest")
        for width in WIDTHS
    ]
    x, y = (np.stack([one[..., axis] for one in by_channel], axis=2).astype(np.float32) for axis in range(2))
    return x, y
