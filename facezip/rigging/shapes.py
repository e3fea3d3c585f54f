"""Step A of example-based rigging: the edges of every shape, triangle by triangle, from scans and from the template."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import kernel
from facezip.machine.rows import map_rows

# Li, Weise and Pauly's: triangles that a shape hardly moves on the template stay with the template.
KAPPA, THETA = 0.1, 2


def trust(strain: NDArray[np.float32]) -> NDArray[np.float32]:
    """How firmly the edges of a shape are held to the template's: w = ((1 + s) / (κ + s))^θ of the strain s."""
    held: NDArray[np.float32] = ((1 + strain) / (np.float32(KAPPA) + strain)) ** THETA
    return held


def explain(
    prior: NDArray[np.float32],
    strain: NDArray[np.float32],
    scans: NDArray[np.float32],
    weights: NDArray[np.float64],
    beta: float,
) -> NDArray[np.float32]:
    """What the shapes do to every element, ``(E, M, C)``: they explain the scans and stay near the template.

    Minimises Σ_j ‖S_j - Σ_i α_ij X_i‖² + β Σ_i w_i ‖X_i - X_i*‖² for each element alone: a triangle with its two edges,
    displaced (normals are left out, which are not linear), or a vertex with its displacement.

    Parameters
    ----------
    prior : ``(E, M, C)``, X*, the template's.
    strain : ``(E, M)`` how much each shape does to an element of the template.
    scans : ``(E, N, C)``, S.
    weights : ``(N, M)``, α.
    beta : how much the template counts.
    """
    held = np.float32(beta) * trust(strain)
    solved = np.empty_like(prior)
    alpha = weights.astype(np.float32)
    map_rows(lambda top, bottom: _solve(top, bottom, alpha, held, prior, scans, solved), len(prior))
    return solved


@kernel(fastmath={"contract", "reassoc"})
def _solve(
    top: int,
    bottom: int,
    alpha: NDArray[np.float32],
    held: NDArray[np.float32],
    prior: NDArray[np.float32],
    scans: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """X = X* + H⁻¹ αᵀ (1 + α H⁻¹ αᵀ)⁻¹ (S - α X*): as many equations as there are scans, not shapes."""
    poses, shapes = alpha.shape
    loose = np.empty((poses, shapes), np.float32)
    for f in range(top, bottom):
        for n in range(poses):
            for m in range(shapes):
                loose[n, m] = alpha[n, m] / held[f, m]
        system = (loose @ alpha.T).astype(np.float64)
        for n in range(poses):
            system[n, n] += 1
        gap = (scans[f] - alpha @ prior[f]).astype(np.float64)
        out[f] = prior[f] + loose.T @ np.linalg.solve(system, gap).astype(np.float32)
