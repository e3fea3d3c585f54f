"""Nesterov's momentum over alternations: far fewer of them reach the same error.

Where the error grows, it went past the goal and is forgotten (O'Donoghue & Candès, Adaptive Restart for Accelerated
Gradient Schemes, 2015).
"""

from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Weights = TypeVar("Weights", NDArray[np.float32], NDArray[np.float64])


def accelerated(
    start: Weights,
    steps: Iterable[int],
    ahead: Callable[[Weights, Weights, float], Weights],
    alternate: Callable[[Weights], tuple[Weights, float]],
) -> Weights:
    """What alternations from ``start`` lead to, one for each of ``steps``.

    Parameters
    ----------
    ahead : of weights W, those before, and a momentum μ: W + μ (W - before), within the bounds of W.
    alternate : of weights the next ones, and how much the given ones explain.
    """
    weights = previous = start
    explained_before, age = -np.inf, 0
    for _ in steps:
        place = ahead(weights, previous, age / (age + 2))
        age += 1
        previous = weights
        weights, explained = alternate(place)
        if explained < explained_before:
            previous, age = weights, 0
        explained_before = explained
    return weights
