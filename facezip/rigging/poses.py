"""Step B of example-based rigging: how much of every shape is in a scan."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear

# Keeps shapes that are hard to tell apart from large weights that cancel.
PULL = 1e-3


def pose_weights(
    shapes: NDArray[np.float32],
    scans: NDArray[np.float32],
    guess: NDArray[np.float64] | None = None,
    pull: float = PULL,
    sparsity: float = 0.0,
) -> NDArray[np.float64]:
    """Weights ``(N, M)`` in [0, 1] of the shapes B in every scan S, each a small problem in their Gram matrix.

    Minimises ‖S_n - Σ_m α_nm B_m‖² + Σ_m ‖B_m‖² (pull · (α_nm - guess_nm)² + 2 · sparsity · α_nm): the terms beside the
    error are measured in each shape's own norm, so that neither units nor the size of a shape matter.

    Parameters
    ----------
    shapes : ``(M, V, 3)`` displacements.
    scans : ``(N, V, 3)`` displacements.
    guess : ``(N, M)``, zero if None.
    pull : how firmly weights are held to the guess.
    sparsity : what a shape that is alone in its place loses of its weight; those that explain less go.
    """
    flat, posed = (values.reshape(len(values), -1).astype(np.float64) for values in (shapes, scans))
    gram = flat @ flat.T
    # A shape that moves nothing has no norm of its own.
    norm = np.maximum(np.diag(gram), max(gram.max() * 1e-9, np.finfo(np.float64).tiny))
    root = cholesky(gram + pull * np.diag(norm))
    right = flat @ posed.T - sparsity * norm[:, None]
    if guess is not None:
        right += (pull * norm * guess).T
    targets = solve_triangular(root, right, trans="T").T
    return np.stack([lsq_linear(root, targets[n], (0, 1), method="bvls").x for n in range(len(scans))])
