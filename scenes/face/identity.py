"""Whose head it is: the sculpt bent into the proportions of a person, with every motion of it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scenes.face.head import Head
from scenes.face.shapes import Pull
from scenes.face.traits import Traits

# What differs from person to person by one standard deviation: on both sides alike, and in the middle.
SIDED = {
    "jaw": Pull((5.3, -6.8, 2.4), (2.4, 3.0, 4.0), (0.34, 0, 0)),
    "cheekbone": Pull((4.9, -1.6, 5.0), (1.9, 1.6, 2.6), (0.24, 0.04, 0.14)),
    "cheek": Pull((4.3, -4.6, 5.4), (1.9, 2.1, 2.6), (0.30, 0, 0.18)),
    "jowl": Pull((4.2, -8.2, 4.8), (1.5, 1.5, 2.2), (0.14, -0.34, 0.08)),
    "brow": Pull((2.4, 2.3, 8.2), (2.5, 1.0, 2.2), (0, -0.03, 0.17)),
    "eye": Pull((3.15, 0.5, 7.0), (2.2, 1.5, 3.0), (0.09, 0, 0)),
    "canthus": Pull((4.7, 0.5, 6.6), (1.0, 0.8, 2.2), (0, 0.13, 0)),
    "wing": Pull((1.35, -3.05, 8.9), (0.95, 1.1, 1.9), (0.15, 0, -0.02)),
    "mouth": Pull((2.5, -6.1, 7.9), (1.2, 1.2, 2.4), (0.16, 0, 0)),
    "neck": Pull((5.0, -14.5, -2.5), (3.4, 4.6, 5.0), (0.40, 0, 0)),
}
CENTRAL = {
    "chin": Pull((0, -9.6, 7.8), (2.3, 1.9, 3.2), (0, -0.22, 0.18)),
    "bridge": Pull((0, 0.2, 8.6), (0.95, 2.0, 2.0), (0, 0, 0.20)),
    "tip": Pull((0, -2.8, 10.0), (1.3, 1.5, 2.2), (0, 0.12, 0.20)),
    "upper lip": Pull((0, -5.65, 9.2), (2.1, 0.55, 2.2), (0, 0.05, 0.11)),
    "lower lip": Pull((0, -6.75, 9.0), (2.0, 0.60, 2.2), (0, -0.06, 0.13)),
    "forehead": Pull((0, 5.6, 7.6), (4.2, 2.8, 4.2), (0, 0, 0.22)),
    "length": Pull((0, -9.5, 4.0), (9.0, 5.0, 9.0), (0, -0.35, 0)),
}
# Standard deviations that women differ from men by on average, that years add, and that dark skin often goes with.
FEMALE = {"jaw": -1.7, "chin": -1.0, "brow": -1.9, "neck": -2.0, "cheekbone": 0.6, "forehead": 0.5, "upper lip": 0.9,
          "lower lip": 0.7, "bridge": -0.5, "wing": -0.6, "length": -0.6, "canthus": 0.5}  # fmt: skip
WORN = {"jowl": 1.3, "cheek": -0.7, "upper lip": -0.9, "lower lip": -0.5, "tip": -0.4, "canthus": -0.6}
DARK = {"wing": 1.5, "upper lip": 1.2, "lower lip": 1.3, "bridge": -0.8}


def shaped(head: Head, deltas: NDArray[np.float32], person: Traits) -> tuple[Head, NDArray[np.float32]]:
    """A person's head and displacements ``(M, V, 3)`` of its shapes, from the sculpt's; seed 0 has the sculpt's."""
    if person.seed == 0:
        return head, deltas
    amounts = proportions(person)
    neutral = bent(head.vertices, amounts)
    moved = np.zeros_like(deltas)
    for shape, delta in zip(moved, deltas, strict=True):
        some = delta.any(axis=1)
        shape[some] = bent(head.vertices[some] + delta[some], amounts) - neutral[some]
    return replace(head, vertices=neutral), moved


def proportions(person: Traits) -> dict[str, float]:
    """What a person differs by, in standard deviations."""
    rng = np.random.default_rng([person.seed, 17])
    return {
        name: 1.3 * float(np.clip(rng.standard_normal(), -1.8, 1.8))
        + person.female * FEMALE.get(name, 0)
        + person.worn * WORN.get(name, 0)
        + person.melanin * DARK.get(name, 0)
        for name in (*SIDED, *CENTRAL)
    }


def bent(vertices: NDArray[np.float32], amounts: dict[str, float]) -> NDArray[np.float32]:
    """Points ``(V, 3)`` where the person has them."""
    points, mirror = vertices.astype(np.float64), np.array([-1.0, 1.0, 1.0])
    moved = points.copy()
    for name, pull in CENTRAL.items():
        moved += amounts[name] * pull.field(points)
    for name, pull in SIDED.items():
        moved += amounts[name] * (pull.field(points) + pull.field(points * mirror) * mirror)
    return moved.astype(np.float32)
