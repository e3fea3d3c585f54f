"""Where a feature of the neutral lies on an expression's texture: in its place, beside it, or nowhere.

A smooth displacement (:mod:`facezip.character.alignment`) passes over a lip that lies on the chin: robust weights take
it for a wrinkle, and averages drown it. Here windows of the size of a lip are looked for around their place, by
normalised correlation. One that fits far better beside its place has slipped; where it fits nowhere and its structure
is gone, it is lost. A wrinkle or an eye that opens adds structure, and is neither. A whole texture that fits better
upside down or mirrored is so.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from facezip.machine.kernels import inner, kernel

# Textures are reduced to at most so many texels a side, and smaller ones than that say nothing.
SIDE, SMALLEST = 256, 64
# Of the reduced texture: half the side of a window, and how far around its place it is looked for.
HALF, REACH = 10, 6
# Side of the neighbourhood whose mean is taken away.
NEIGHBOURHOOD = 15
# A window that fits so well in its place is not looked for elsewhere.
IN_PLACE = 0.6
# It has slipped by more than so many texels of the reduced texture (good captures are off by one) where it fits so well
# elsewhere, and by so much better; it is lost where it fits nowhere better than this, and less than so much of its
# structure is left. So many windows have to say so.
LEAST, FITS, BETTER = 1.0, 0.8, 0.4
LOST, LEFT = 0.7, 0.4
WINDOWS = 2
# Texels a side of what a whole texture is compared by, and how well it fits turned and as it is.
WHOLE = 64
TURNED, AS_IT_IS = 0.5, 0.25
# A face is nearly its own mirror image, and fits both ways. What it is not alike in then fits with the other sign, by
# more than this (0.3 to 0.9 in real and made faces).
OPPOSITE = 0.2


_BACK, _ALL = slice(None, None, -1), slice(None)
FLIPS = {"upside down": (_BACK, _ALL), "mirrored": (_ALL, _BACK), "turned by half": (_BACK, _BACK)}


class Feature(NamedTuple):
    """What became of a window of the neutral.

    Attributes
    ----------
    state : ``slipped`` or ``lost``.
    texels : how far it slipped, in texels of the reduced texture; 0 of a lost one.
    u, v : its place in the texture.
    """

    state: str
    texels: float
    u: float
    v: float


def worst_feature(
    neutral: NDArray[np.float32], other: NDArray[np.float32], cells: NDArray[np.float32]
) -> Feature | None:
    """The feature that slipped farthest, or else one that is lost; None where all are in their place.

    Parameters
    ----------
    neutral, other : ``(h, w)`` log luminance of reduced textures.
    cells : ``(G, G)`` in [0, 1], how much of each cell of a grid is on the face.
    """
    if min(neutral.shape) < SMALLEST:
        return None
    still, moved = (image - uniform_filter(image, NEIGHBOURHOOD) for image in (neutral, other))
    found = np.zeros((*cells.shape, 6))
    _matched(still, moved, cells > 0.5, HALF, REACH, IN_PLACE, found)
    here, best, across, down, structure, left = np.moveaxis(found, 2, 0)
    there = structure > 0
    if not there.any():
        return None
    strong = there & (structure >= np.median(structure[there]))
    inside = np.maximum(np.abs(across), np.abs(down)) < REACH
    length = np.hypot(across, down)
    slipped = strong & inside & (length > LEAST) & (best >= FITS) & (best - here >= BETTER)
    lost = strong & (best < LOST) & (left < LEFT)
    if slipped.sum() >= WINDOWS:
        return _at("slipped", np.where(slipped, length, -1), length)
    return _at("lost", np.where(lost, -left, -np.inf), 0 * length) if lost.sum() >= WINDOWS else None


def _at(state: str, score: NDArray[np.float64], length: NDArray[np.float64]) -> Feature:
    row, column = np.unravel_index(score.argmax(), score.shape)
    rows, columns = score.shape
    return Feature(state, float(length[row, column]), (column + 0.5) / columns, 1 - (row + 0.5) / rows)


def turned(neutral: NDArray[np.float32], other: NDArray[np.float32]) -> str | None:
    """How a texture is turned against the neutral's, in words; None where it is not.

    ``neutral`` and ``other`` are as of :func:`worst_feature`.
    """
    if min(neutral.shape) < SMALLEST:
        return None
    step = max(min(neutral.shape) // WHOLE, 1)
    still, moved = (_whole(image, step) for image in (neutral, other))
    ways = {how: moved[flip] for how, flip in FLIPS.items()}
    if moved.shape[0] == moved.shape[1]:
        ways |= {"turned by a quarter": np.rot90(moved), "turned back by a quarter": np.rot90(moved, -1)}
        ways |= {"transposed": moved.T, "transposed and turned by half": moved[::-1, ::-1].T}
    fits = {how: _correlation(still, image) for how, image in ways.items()}
    how = max(fits, key=fits.__getitem__)
    if fits[how] <= TURNED:
        return None
    return how if _correlation(still, moved) < AS_IT_IS or _opposite(still, moved, how) else None


def _opposite(still: NDArray[np.float32], moved: NDArray[np.float32], how: str) -> bool:
    """Whether the parts of two images that change their sign when they are turned are opposite."""
    if how not in FLIPS:
        return False
    turned_still, turned_moved = (image[FLIPS[how]] for image in (still, moved))
    return _correlation(still - turned_still, moved - turned_moved) < -OPPOSITE


def _whole(image: NDArray[np.float32], step: int) -> NDArray[np.float32]:
    rows, columns = (size // step * step for size in image.shape)
    means: NDArray[np.float32] = image[:rows, :columns].reshape(rows // step, step, -1, step).mean(axis=(1, 3))
    return means - uniform_filter(means, NEIGHBOURHOOD)


def _correlation(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    return float(np.vdot(one, other) / max(float(np.sqrt(np.vdot(one, one) * np.vdot(other, other))), 1e-12))


@kernel(error_model="numpy")
def _matched(
    still: NDArray[np.float32],
    moved: NDArray[np.float32],
    face: NDArray[np.bool_],
    half: int,
    reach: int,
    in_place: float,
    found: NDArray[np.float64],
) -> None:
    """For every window: its correlation in place and at best, where that is, its structure, and what is left of it."""
    height, width = still.shape
    rows, columns = face.shape
    for i in range(rows):
        for j in range(columns):
            y, x = (2 * i + 1) * height // (2 * rows), (2 * j + 1) * width // (2 * columns)
            top, bottom = max(y - half, reach), min(y + half + 1, height - reach)
            left, right = max(x - half, reach), min(x + half + 1, width - reach)
            if not face[i, j] or bottom - top < half or right - left < half:
                continue
            squares = 0.0
            for row in range(top, bottom):
                for column in range(left, right):
                    squares += still[row, column] * still[row, column]
            here, others = _correlated(still, moved, top, bottom, left, right, 0, 0, squares)
            cell = found[i, j]
            cell[0], cell[1], cell[4] = here, here, squares / ((bottom - top) * (right - left))
            cell[5] = np.sqrt(others / max(squares, 1e-12))
            if here > in_place:
                continue
            for down in range(-reach, reach + 1):
                for across in range(-reach, reach + 1):
                    fit, _ = _correlated(still, moved, top, bottom, left, right, down, across, squares)
                    if fit > cell[1]:
                        cell[1], cell[2], cell[3] = fit, across, down


@inner(error_model="numpy", inline="always")
def _correlated(
    still: NDArray[np.float32],
    moved: NDArray[np.float32],
    top: int,
    bottom: int,
    left: int,
    right: int,
    down: int,
    across: int,
    squares: float,
) -> tuple[float, float]:
    """Correlation of a window with what lies so far from it, and the sum of that one's squares."""
    both, others = 0.0, 0.0
    for row in range(top, bottom):
        for column in range(left, right):
            value = moved[row + down, column + across]
            both += still[row, column] * value
            others += value * value
    return both / np.sqrt(max(squares * others, 1e-20)), others
