"""A template for example-based rigging: another person who never was, in the topology of the first.

python -m scenes.template out/template
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.files.obj import write_obj
from facezip.machine.progress import track
from facezip.rigging.template import Template
from scenes.face.head import build_head
from scenes.face.shapes import ARKIT_SHAPES, shape_deltas

# Of a head's height: how far bumps of the new identity reach, and how far they move a point at most.
REACH, DEPTH, BUMPS = 0.22, 0.016, 40
# How much stronger or weaker a shape is on another person, as a whole and from place to place (standard deviations).
STRENGTH, UNEVENNESS = 0.12, 0.12

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bumps:
    """A smooth random field over space: a sum of Gaussians.

    Attributes
    ----------
    centres : ``(K, 3)``.
    reach : standard deviation of every Gaussian.
    heights : ``(K, C)``.
    """

    centres: Points
    reach: float
    heights: Points

    def at(self, points: Points) -> Points:
        """Values ``(V, C)`` at points ``(V, 3)``."""
        total = np.zeros((len(points), self.heights.shape[1]))
        for centre, height in zip(self.centres, self.heights, strict=True):
            distance = np.sum(np.square(points - centre), axis=1) / self.reach**2
            total += np.exp(-0.5 * distance)[:, None] * height
        return total


def another_identity(
    vertices: NDArray[np.float32], deltas: NDArray[np.float32], seed: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """A neutral ``(V, 3)`` and displacements ``(M, V, 3)`` of a person with other proportions and other muscles.

    Space is bent by a smooth random field, so that proportions change and every motion turns and stretches with them;
    before that, each shape becomes stronger or weaker, as a whole and from place to place.
    """
    rng = np.random.default_rng([seed, 11])
    points = vertices.astype(np.float64)
    height = float(np.ptp(points[:, 1]))
    bend = _bumps(points, height, DEPTH * height, 3, rng)
    neutral = points + bend.at(points)
    strengths = np.exp(STRENGTH * rng.standard_normal(len(deltas)))
    moved = np.empty(deltas.shape, np.float32)
    for m, delta in enumerate(deltas):
        uneven = np.exp(_bumps(points, height, UNEVENNESS, 1, rng).at(points))
        posed = points + strengths[m] * uneven * delta
        moved[m] = posed + bend.at(posed) - neutral
    return neutral.astype(np.float32), moved


def _bumps(points: Points, height: float, size: float, channels: int, rng: np.random.Generator) -> Bumps:
    """Bumps all over the points whose sum has about the standard deviation ``size``."""
    centres = points[rng.choice(len(points), BUMPS, replace=False)]
    field = Bumps(centres, REACH * height, rng.standard_normal((BUMPS, channels)))
    some = field.at(points[:: max(len(points) // 2000, 1)])
    return Bumps(centres, field.reach, field.heights * (size / np.sqrt(np.mean(some**2))))


def embedded_template(seed: int = 1) -> Template:
    """The 52 ARKit shapes of the embedded character's head on another identity, one a seed."""
    head = build_head()
    return Template(ARKIT_SHAPES, *another_identity(head.vertices, shape_deltas(head), seed))


def save_template(folder: Path, seed: int = 1) -> None:
    """Write the embedded character's template: ``neutral.obj`` and ``NAME.obj`` for each of the 52 ARKit shapes."""
    head = build_head()
    template = embedded_template(seed)
    neutral, deltas = template.neutral, template.deltas
    folder.mkdir(parents=True, exist_ok=True)
    write_obj(folder / "neutral.obj", neutral, head.topology)
    for name, delta in track(zip(ARKIT_SHAPES, deltas, strict=True), "Writing the template", len(deltas)):
        write_obj(folder / f"{name}.obj", neutral + delta, head.topology)


if __name__ == "__main__":
    save_template(Path(sys.argv[1]))
