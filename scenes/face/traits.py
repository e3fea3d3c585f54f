"""Who the embedded character is: sex, age and colours of a person, drawn from a seed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# Skin from the least melanin to the most, encoded sRGB.
SKIN = np.array(
    [[0.880, 0.715, 0.640], [0.815, 0.630, 0.545], [0.735, 0.550, 0.445], [0.575, 0.405, 0.310], [0.375, 0.250, 0.190]]
)
IRISES = np.array([[0.30, 0.37, 0.42], [0.35, 0.26, 0.15], [0.28, 0.31, 0.22], [0.15, 0.095, 0.065]])
HAIR = np.array([[0.46, 0.35, 0.22], [0.24, 0.16, 0.11], [0.13, 0.095, 0.08], [0.07, 0.06, 0.058]])
GREY = np.array([0.60, 0.585, 0.565])


class Traits(NamedTuple):
    """A person; kernels take it as it is.

    Attributes
    ----------
    female : 0 for a man, 1 for a woman.
    age : years.
    melanin : in [0, 1], how dark the skin is.
    skin, lip, iris, hair : ``(3,)`` encoded sRGB in [0, 1].
    freckles, beard, blood : in [0, 1]: how many, how dense, how ruddy.
    brow : how thick the brows are, 1 for a man's of the middle.
    seed : of everything else about the person.
    """

    female: float
    age: float
    melanin: float
    skin: NDArray[np.float64]
    lip: NDArray[np.float64]
    iris: NDArray[np.float64]
    hair: NDArray[np.float64]
    freckles: float
    beard: float
    blood: float
    brow: float
    seed: int

    @property
    def worn(self) -> float:
        """How much the years have marked the skin, 0 at 22 and 1 at 70."""
        return min(max((self.age - 22) / 48, 0.0), 1.2)


def traits(seed: int) -> Traits:
    """The person with this seed; seed 0 is the one in the pictures, a man of 36 years with light skin."""
    rng = np.random.default_rng([seed, 7])
    chance = rng.uniform(0, 1, 9)
    if seed == 0:
        chance = np.array([0.2, 0.32, 0.24, 0.5, 0.45, 0.5, 0.55, 0.0, 0.45])
    female = float(chance[0] > 0.5)
    age, melanin = 22 + 44 * chance[1], float(chance[2])
    skin = np.array([np.interp(melanin, np.linspace(0, 1, len(SKIN)), SKIN[:, c]) for c in range(3)])
    lip = skin * np.array([0.90 - 0.04 * melanin, 0.70, 0.73]) * (1 - 0.06 * melanin)
    # Dark skin goes with dark eyes and hair.
    dark = min(melanin / 0.55, 1.0)
    iris = IRISES[3] if chance[3] < dark - 0.2 else IRISES[int(chance[7] * len(IRISES))]
    colour = np.clip(dark + 0.5 * (chance[4] - 0.5) + 0.15, 0, 1) * (len(HAIR) - 1)
    hair = np.array([np.interp(colour, np.arange(len(HAIR)), HAIR[:, c]) for c in range(3)])
    grey = float(np.clip((age - 42 - 16 * chance[5]) / 26, 0, 0.85))
    return Traits(
        female,
        float(age),
        melanin,
        skin,
        lip,
        iris,
        hair + grey * (GREY - hair),
        float(chance[5] * (1 - melanin) ** 2),
        0.0 if female else float(0.35 + 0.6 * chance[6]),
        float((0.65 + 0.7 * chance[8]) * (1 - 0.45 * melanin)),
        float((0.72 if female else 1.0) * (0.85 + 0.3 * chance[4])),
        seed,
    )
