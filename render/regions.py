"""Where on a face: names for parts of any head, from its geometry alone.

A head looks to +z with y up. The tip of the nose is its foremost point; half the breadth of the face is how far it
reaches to the side before it has fallen back as far: both hold for a whole bust and for a mere mask of a face, in any
unit. All else is proportion. Left is the character's left, +x.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from facezip.files.obj import Topology
from render.documents.images import ErrorPlace
from render.metrics import window_means

# Side, height and depth of each region in half breadths of the face from the tip of the nose; the first that fits.
# A name with {} exists on both sides.
_ANYWHERE = (-99.0, 99.0)
_RULES = (
    ("neck", (0, 99), (-99, -1.35), _ANYWHERE),
    ("neck", (0, 99), (-99, -0.7), (0.95, 99)),
    ("{} ear", (0.7, 99), (-0.7, 0.95), (1.15, 99)),
    ("scalp", (0, 99), _ANYWHERE, (1.15, 99)),
    ("scalp", (0, 99), (1.75, 99), _ANYWHERE),
    ("forehead", (0, 99), (1.0, 99), _ANYWHERE),
    ("brows", (0, 0.9), (0.74, 1.0), _ANYWHERE),
    ("nose", (0, 0.2), (0.25, 0.74), _ANYWHERE),
    ("{} eye", (0, 0.86), (0.28, 0.74), _ANYWHERE),
    ("{} temple", (0, 99), (0.28, 1.0), _ANYWHERE),
    ("nose", (0, 0.32), (-0.2, 0.28), _ANYWHERE),
    ("mouth", (0, 0.52), (-0.76, -0.2), _ANYWHERE),
    ("chin", (0, 0.45), (-99, -0.76), _ANYWHERE),
    ("{} cheek", (0, 99), (-0.6, 0.28), _ANYWHERE),
    ("{} jaw", (0, 99), _ANYWHERE, _ANYWHERE),
)
NAMES = tuple(
    dict.fromkeys(name.format(side) for name, *_ in _RULES for side in (("left", "right") if "{" in name else ("",)))
)

# A region counts in a render where it has this share of the head's pixels: smaller ones are slivers at the outline.
LEAST_SHARE = 0.01


def face_regions(topology: Topology, neutral: NDArray[np.float32]) -> NDArray[np.int32]:
    """The region of every triangle ``(F,)``, an index into :data:`NAMES`, from neutral vertices ``(V, 3)``."""
    tip, breadth = _landmarks(neutral)
    centres = (neutral[topology.faces].mean(axis=1) - tip) / breadth
    side, height, depth = np.abs(centres[:, 0]), centres[:, 1], -centres[:, 2]
    regions = np.full(len(centres), -1, np.int32)
    for name, *ranges in _RULES:
        fits = regions < 0
        for value, (low, high) in zip((side, height, depth), ranges, strict=True):
            fits &= (value >= low) & (value < high)
        left, right = (NAMES.index(name.format(word) if "{" in name else name) for word in ("left", "right"))
        regions[fits] = np.where(centres[fits, 0] >= 0, left, right)
    return regions


def _landmarks(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float64], float]:
    """The tip of the nose ``(3,)`` and half the breadth of the face."""
    points = vertices.astype(np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    centre, size = (low + high) / 2, high - low
    middle = (np.abs(points - centre) <= size * [0.1, 0.35, 1.0])[:, :2].all(axis=1)
    front = points[middle] if middle.any() else points
    tip = front[front[:, 2].argmax()]
    aside, behind = np.abs(points[:, 0] - tip[0]), tip[2] - points[:, 2]
    level = (np.abs(points[:, 1] - tip[1]) <= 0.06 * size[1]) & (behind <= aside)
    breadth = float(aside[level].max(initial=0.0))
    return tip, breadth if breadth > 0 else float(size.max())


def locate(
    error: NDArray[np.float32], head: NDArray[np.bool_], regions: NDArray[np.int32]
) -> tuple[dict[str, float], ErrorPlace | None]:
    """Which part of a face an error is on.

    Parameters
    ----------
    error : ``(h, w)`` ΔE2000.
    head : ``(h, w)``, the pixels that count.
    regions : ``(h, w)`` indices into :data:`NAMES`, -1 for none.

    Returns
    -------
    The 95th percentile of each region seen; and, where there is an error, the place where it is largest.
    """
    labels = np.where(head, regions, -1)
    counts = np.bincount(labels[labels >= 0], minlength=len(NAMES))
    seen = np.flatnonzero(counts >= max(LEAST_SHARE * head.sum(), 1))
    errors = {NAMES[i]: float(np.percentile(error[labels == i], 95)) for i in seen}
    inside = np.isin(labels, seen)
    if not error[inside].any():
        return errors, None
    # The smallest window that is a place finds it: a percentile misses what is smaller than a twentieth of a region.
    means = np.zeros(error.shape)
    means[head] = window_means(error[head], head)
    row, column = np.unravel_index(np.where(inside, means, -1).argmax(), error.shape)
    worst = NAMES[labels[row, column]]
    box = _box(np.where(head, error, 0), labels == NAMES.index(worst))
    return errors, ErrorPlace(region=worst, delta_e_p95=errors[worst], box=box)


def _box(error: NDArray[np.float32], inside: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    side = min(max(min(error.shape) // 4, 8), *error.shape)
    local = uniform_filter(error.astype(np.float32), side, mode="constant")
    row, column = np.unravel_index(np.where(inside, local, -1).argmax(), error.shape)
    top = min(max(int(row) - side // 2, 0), error.shape[0] - side)
    left = min(max(int(column) - side // 2, 0), error.shape[1] - side)
    return top, left, side, side
