"""What numbers of meshes are measured in: the units that may be stated, what a head's size makes likely, and metres.

Meshes whose unit ``character.toml`` states are brought to centimetres when they are read, and are known to be so from
then on (:attr:`facezip.character.meshes.Meshes.centimetres`). Of others nothing is known, and nothing is changed.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.files.obj import used_rows

# Of each unit, in centimetres, and what people call it.
UNITS = {"m": 100.0, "cm": 1.0, "mm": 0.1, "in": 2.54, "ft": 30.48}
WORDS = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches", "ft": "feet"}
# Centimetres of a head's height, from chin to crown; 0.6 and 1.7 times that are heads too, and busts.
HEAD, SMALLER, LARGER = 24.0, 0.6, 1.7


def likely_unit(extents: NDArray[np.floating]) -> str | None:
    """The key of :data:`UNITS` in which extents ``(3,)`` are those of a head; None where they are in none of them."""
    largest = float(extents.max())
    return next((unit for unit, many in UNITS.items() if SMALLER < largest * many / HEAD < LARGER), None)


def in_metres(meshes: Meshes) -> Meshes:
    """Meshes in the metres of file formats; those of which no unit is known as they are."""
    if not meshes.centimetres:
        return meshes
    neutral, vertices = (
        (each.astype(np.float64) / 100).astype(np.float32) for each in (meshes.neutral, meshes.vertices)
    )
    return replace(meshes, neutral=neutral, vertices=vertices, centimetres=False)


def size_words(meshes: Meshes | None, reads: str) -> list[str]:
    """What is said of the size of a head that is read in the unit ``reads``, a key of :data:`UNITS`.

    A sentence where there is a head, unless it is likely to be in that unit and nothing is said of it.
    """
    if meshes is None:
        return []
    extents = np.ptp(used_rows(meshes.neutral, meshes.topology.faces), axis=0)
    height, likely = float(extents[1]), likely_unit(extents)
    if meshes.centimetres:
        return [f"the head is {height / 100:.3g} m tall, as its unit is known"]
    if likely == reads:
        return []
    remedy = f'say unit = "{likely or "cm"}" in character.toml and compress again'
    guess = f"probably {WORDS[likely]}" if likely else "and no unit makes it the size of a head"
    return [f"the head keeps the numbers of the scans and is {height:.3g} {WORDS[reads]} tall, {guess}; {remedy}"]
