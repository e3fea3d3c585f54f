"""The best textures and weight maps that equation (1) can hold: alternating least squares under bilinear sampling.

Minimises Σ_n Σ_p m(p) ‖D_n(p) - Σ_i D_i(p) (U W_in)(p)‖² + λ Σ ‖∇W‖², U the bilinear upsampling that a GPU sampler
does. Weights fixed, the R values of every texel are a small linear solve; textures fixed, the weights are a sparse
system whose matrix all expressions share. PCA is the special case of constant weights, and the start. One pass over the
texels a step: it solves each texel and adds it to the next step's system.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.baselines import principal_components
from facezip.character import Character
from facezip.fragments import differences_of_row, texel_scale
from facezip.model import CompressedTextures, bilinear_taps
from facezip.progress import track
from facezip.rows import map_rows

# The first row of weight texels that a block of texture rows samples, and its share of the system there.
Part: TypeAlias = tuple[int, NDArray[np.float64], NDArray[np.float64]]

ALTERNATIONS = 13
CG_STEPS = 20
# Of the mean diagonal of the weights' system: fills what no texel sees and keeps noise out of the weights.
SMOOTHNESS = 1e-3
# Of the mean trace of a texel's system: bounds D where all weights are small.
RIDGE = 1e-5


@dataclass(frozen=True, eq=False)
class WeightSystem:
    """Normal equations of all weight maps: ``matrix · W_n = right_n`` on a grid of low-resolution texels.

    Attributes
    ----------
    matrix : ``(h, w, 9, R, R)``, coupling of a texel with its 3 x 3 neighbours, row by row.
    right : ``(h, w, R, N)``.
    """

    matrix: NDArray[np.float64]
    right: NDArray[np.float64]


def refine(character: Character, differences: int, weight_scale: int) -> CompressedTextures:
    """``differences`` textures and weight maps at 1/``weight_scale`` that minimise the error inside the mask."""
    start = principal_components(character, min(differences, len(character.expressions)))
    height, width = character.resolution
    h, w = -(-height // weight_scale), -(-width // weight_scale)
    # (h, w, R, N): the N expressions of a texel lie together for vector registers.
    weights = np.ascontiguousarray(
        np.broadcast_to(start.weights[:, 0, 0].T, (h, w, start.weights.shape[3], len(start.weights)))
    )
    smoothness = 0.0
    for _ in track(range(ALTERNATIONS), "Refining", ALTERNATIONS):
        system = weight_system(character, weights)
        smoothness = smoothness or SMOOTHNESS * float(
            np.einsum("hwii->", system.matrix[:, :, 4]) / weights[..., 0].size
        )
        weights = solve_weights(system, smoothness, weights)
    weights = rounded(weights)
    return CompressedTextures(
        neutral=start.neutral,
        differences=solve_textures(character, weights),
        weights=np.ascontiguousarray(weights.transpose(3, 0, 1, 2)),
        expressions=character.expressions,
        method="refined",
    )


def rounded(weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weights ``(h, w, R, N)`` as 8 bits hold them, so that the textures can be fitted to what is stored."""
    low = weights.min(axis=(0, 1, 3))[:, None]
    scale = (weights.max(axis=(0, 1, 3))[:, None] - low) / np.float32(255)
    return np.rint((weights - low) / np.where(scale > 0, scale, 1)) * scale + low


def solve_textures(character: Character, weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """The difference textures ``(R, H, W, C)`` that fit best under given weights ``(h, w, R, N)``."""
    height, width = character.resolution
    textures = np.empty((weights.shape[2], height, width, character.neutral.shape[2]), np.float32)
    unused = np.empty((0, 0, 9, 0, 0)), np.empty((0, 0, 0, 0))
    _sweep(character, weights, textures, lambda top, bottom: (0, *unused))
    return textures


def weight_system(character: Character, weights: NDArray[np.float32]) -> WeightSystem:
    """The system of the weight maps under the textures that fit best to the given weights ``(h, w, R, N)``."""
    h, w, slots, count = weights.shape
    first, second, _ = bilinear_taps(character.resolution[0], h)
    matrix, right = np.zeros((h, w, 9, slots, slots)), np.zeros((h, w, slots, count))

    def empty(top: int, bottom: int) -> Part:
        rows = int(second[bottom - 1] - first[top] + 1)
        return int(first[top]), np.zeros((rows, *matrix.shape[1:])), np.zeros((rows, *right.shape[1:]))

    for begin, part, right_part in _sweep(character, weights, np.empty((slots, 0, 0, 0), np.float32), empty):
        matrix[begin : begin + len(part)] += part
        right[begin : begin + len(part)] += right_part
    return WeightSystem(matrix, right)


def solve_weights(system: WeightSystem, smoothness: float, start: NDArray[np.float32]) -> NDArray[np.float32]:
    """Conjugate gradients from ``start``, preconditioned by the inverse of each texel's own block."""
    matrix = _with_smoothness(system.matrix, smoothness)
    blocks = np.linalg.inv(matrix[:, :, 4])
    x = start.astype(np.float64)
    residual = system.right - _multiply(matrix, x)
    direction = z = blocks @ residual
    energy = _dot(residual, z)
    for _ in range(CG_STEPS):
        image = _multiply(matrix, direction)
        step = _ratio(energy, _dot(direction, image))
        x += step * direction
        residual -= step * image
        z = blocks @ residual
        before, energy = energy, _dot(residual, z)
        direction = z + _ratio(energy, before) * direction
    return x.astype(np.float32)


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    products: NDArray[np.float64] = np.einsum("hwrn,hwrn->n", a, b)
    return products


def _ratio(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)


def _with_smoothness(matrix: NDArray[np.float64], smoothness: float) -> NDArray[np.float64]:
    """Add λ times the Laplacian of the grid of low-resolution texels."""
    smooth = matrix.copy()
    diagonal = np.arange(matrix.shape[3])
    inner = slice(1, None), slice(None, -1)
    for here, neighbour in ((1, (inner[0], slice(None))), (7, (inner[1], slice(None)))):
        smooth[neighbour][:, :, here, diagonal, diagonal] -= smoothness
        smooth[neighbour][:, :, 4, diagonal, diagonal] += smoothness
    for here, neighbour in ((3, (slice(None), inner[0])), (5, (slice(None), inner[1]))):
        smooth[neighbour][:, :, here, diagonal, diagonal] -= smoothness
        smooth[neighbour][:, :, 4, diagonal, diagonal] += smoothness
    # A grid where no texel counts at all would be singular.
    smooth[:, :, 4, diagonal, diagonal] += max(1e-9 * smoothness, 1e-300)
    return smooth


def _multiply(matrix: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    out = np.empty_like(x)
    map_rows(lambda top, bottom: _multiply_rows(top, bottom, matrix, x, out), len(x))
    return out


def _sweep(
    character: Character,
    weights: NDArray[np.float32],
    textures: NDArray[np.float32],
    empty: Callable[[int, int], Part],
) -> list[Part]:
    """One pass over the texels: writes what is solved to ``textures`` unless it has no rows, returns filled parts."""
    height, width = character.resolution
    mask = np.ones((height, width), np.float32) if character.mask is None else character.mask
    stored = character.textures, character.neutral, texel_scale(character), mask
    taps = *bilinear_taps(height, weights.shape[0]), *bilinear_taps(width, weights.shape[1])
    ridge = np.float32(RIDGE * np.square(weights).sum(dtype=np.float64) / (weights.shape[0] * weights.shape[1]))

    def block(top: int, bottom: int) -> Part:
        part = empty(top, bottom)
        _sweep_rows(top, bottom, *stored, weights, *taps, ridge, textures, *part)
        return part

    return map_rows(block, height)


@njit(cache=True, nogil=True)
def _multiply_rows(
    top: int, bottom: int, matrix: NDArray[np.float64], x: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    h, w, slots, count = x.shape
    for y in range(top, bottom):
        for column in range(w):
            total = out[y, column]
            total[:] = 0
            for q in range(9):
                ny, nx = y + q // 3 - 1, column + q % 3 - 1
                if 0 <= ny < h and 0 <= nx < w:
                    for i in range(slots):
                        for j in range(slots):
                            coupling = matrix[y, column, q, i, j]
                            for n in range(count):
                                total[i, n] += coupling * x[ny, nx, j, n]


@njit(cache=True, nogil=True)
def _solve_texel(
    weights: NDArray[np.float32],
    differences: NDArray[np.float32],
    ridge: np.float32,
    normal: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Least squares ``weights.T (N, R) · out (R, C) = differences.T (N, C)`` by Cholesky factors."""
    slots, count = weights.shape
    channels = len(differences)
    for i in range(slots):
        for j in range(i + 1):
            total = np.float32(0)
            for n in range(count):
                total += weights[i, n] * weights[j, n]
            normal[i, j] = total
        normal[i, i] += ridge
        for c in range(channels):
            total = np.float32(0)
            for n in range(count):
                total += weights[i, n] * differences[c, n]
            out[i, c] = total
    for i in range(slots):
        for j in range(i):
            for k in range(j):
                normal[i, j] -= normal[i, k] * normal[j, k]
            normal[i, j] /= normal[j, j]
            normal[i, i] -= normal[i, j] * normal[i, j]
        normal[i, i] = np.sqrt(max(normal[i, i], ridge))
        for c in range(channels):
            for k in range(i):
                out[i, c] -= normal[i, k] * out[k, c]
            out[i, c] /= normal[i, i]
    for i in range(slots - 1, -1, -1):
        for c in range(channels):
            for k in range(i + 1, slots):
                out[i, c] -= normal[k, i] * out[k, c]
            out[i, c] /= normal[i, i]


@njit(cache=True, nogil=True)
def _add_texel(
    solved: NDArray[np.float32],
    differences: NDArray[np.float32],
    weight: np.float32,
    at: tuple[int, int, int, int],
    share: tuple[np.float32, np.float32],
    matrix: NDArray[np.float64],
    right: NDArray[np.float64],
    scratch: NDArray[np.float64],
) -> None:
    """Add one texel to the equations of the four weight texels ``at`` that it samples."""
    slots, channels = solved.shape
    count = differences.shape[1]
    products = np.zeros((slots, slots), np.float32)
    for i in range(slots):
        for j in range(slots):
            for c in range(channels):
                products[i, j] += solved[i, c] * solved[j, c]
        for n in range(count):
            scratch[i, n] = 0
        for c in range(channels):
            for n in range(count):
                scratch[i, n] += solved[i, c] * differences[c, n]
    for a in range(4):
        ya, xa = at[a // 2], at[2 + a % 2]
        part = weight * (share[0] if a // 2 else 1 - share[0]) * (share[1] if a % 2 else 1 - share[1])
        if part == 0:
            continue
        for i in range(slots):
            for n in range(count):
                right[ya, xa, i, n] += part * scratch[i, n]
        for b in range(4):
            yb, xb = at[b // 2], at[2 + b % 2]
            both = part * (share[0] if b // 2 else 1 - share[0]) * (share[1] if b % 2 else 1 - share[1])
            cell = matrix[ya, xa, 3 * (yb - ya + 1) + xb - xa + 1]
            for i in range(slots):
                for j in range(slots):
                    cell[i, j] += both * products[i, j]


@njit(cache=True, nogil=True)
def _sweep_rows(
    top: int,
    bottom: int,
    textures: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    mask: NDArray[np.float32],
    weights: NDArray[np.float32],
    row0: NDArray[np.int64],
    row1: NDArray[np.int64],
    row_f: NDArray[np.float32],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
    ridge: np.float32,
    solutions: NDArray[np.float32],
    begin: int,
    matrix: NDArray[np.float64],
    right: NDArray[np.float64],
) -> None:
    count, _, width, channels = textures.shape
    _, w, slots, _ = weights.shape
    differences = np.empty((width, channels, count), np.float32)
    mixed = np.empty((w, slots, count), np.float32)
    sampled = np.empty((slots, count), np.float32)
    normal = np.empty((slots, slots), np.float32)
    solved = np.empty((slots, channels), np.float32)
    scratch = np.empty((slots, count))
    for y in range(top, bottom):
        differences_of_row(y, textures, neutral, scale, differences)
        fy = row_f[y]
        for x in range(w):
            for i in range(slots):
                for n in range(count):
                    mixed[x, i, n] = (1 - fy) * weights[row0[y], x, i, n] + fy * weights[row1[y], x, i, n]
        for x in range(width):
            fx = column_f[x]
            for i in range(slots):
                for n in range(count):
                    sampled[i, n] = (1 - fx) * mixed[column0[x], i, n] + fx * mixed[column1[x], i, n]
            _solve_texel(sampled, differences[x], ridge, normal, solved)
            if solutions.shape[1]:
                for i in range(slots):
                    for c in range(channels):
                        solutions[i, y, x, c] = solved[i, c]
            if len(matrix) and mask[y, x] > 0:
                at = (row0[y] - begin, row1[y] - begin, column0[x], column1[x])
                _add_texel(solved, differences[x], mask[y, x], at, (fy, fx), matrix, right, scratch)
