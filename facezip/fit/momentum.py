"""Nesterov's momentum over alternations of activations: far fewer of them reach the same error.

Where the error grows, it went past the goal and is forgotten (O'Donoghue & Candès, Adaptive Restart for Accelerated
Gradient Schemes, 2015).
"""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray


def accelerated(
    start: NDArray[np.float64],
    steps: Iterable[int],
    ahead: Callable[[NDArray[np.float64], NDArray[np.float64], float], NDArray[np.float64]],
    alternate: Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], float]],
) -> NDArray[np.float64]:
    """The activations that alternations from ``start`` lead to, one for each of ``steps``.

    Parameters
    ----------
    ahead : of activations A, those before, and a momentum μ: A + μ (A - before), within their bounds.
    alternate : of activations the next ones, and how much the given ones explain.
    """
    activations = previous = start
    explained_before, age = -np.inf, 0
    for _ in steps:
        place = ahead(activations, previous, age / (age + 2))
        age += 1
        previous = activations
        activations, explained = alternate(place)
        if explained < explained_before:
            previous, age = activations, 0
        explained_before = explained
    return activations
