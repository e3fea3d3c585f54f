"""The lines in which a face folds: where they lie is the person's for life, how deep they are the expression's.

Points are x and y on the front of the neutral head, in cm.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from scenes.face.traits import Traits

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Line:
    """A line of the face.

    Attributes
    ----------
    points : ``(K, 2)``, cm.
    width : of its valley, from the middle to where it has a third of its depth, cm.
    strength : how readily it folds, 0..1.
    steep : the slope that its sides come to; folds of thick skin are soft.
    permanent : how much of it is there when the face is at rest, 0..1.
    layer : lines of one layer lie side by side; those of another may cross them.
    """

    points: Points
    width: float
    strength: float
    steep: float = 0.55
    permanent: float = 0.0
    layer: int = 0


def lines_of(person: Traits) -> list[Line]:
    """All lines of a person: the two sides have the same ones, and none is another's mirror image."""
    rng, worn = np.random.default_rng([person.seed, 13]), person.worn
    lines = [*_forehead(rng, worn), *_nose_root(rng, worn), *_mouth(rng, worn), *_neck(rng, worn)]
    for side in (-1.0, 1.0):
        sided = [*_frown(rng, worn), *_nose(rng), *_eye(rng, worn), *_cheek(rng, worn)]
        lines += [replace(line, points=line.points * [side, 1]) for line in sided]
    return lines


def _forehead(rng: Generator, worn: float) -> list[Line]:
    """Four or five lines over the arches of the brows, each broken, and short ones between them."""
    lines, count = [], int(rng.integers(4, 6))
    for n in range(count):
        height = 4.0 + n * 3.0 / count + rng.normal(0, 0.08)
        width, start = 0.072 + 0.025 * rng.random(), -4.6 + rng.random() * 0.8
        while start < 3.2:
            end = min(start + rng.uniform(2.2, 6.5), 4.5 - 0.5 * rng.random())
            points = _arched(height + rng.normal(0, 0.07), start, end)
            strength = (0.75 + 0.25 * rng.random()) * (1 - 0.12 * n)
            lines.append(Line(_curve(points, rng, 0.03, 0.025), width, strength, 0.6, 0.36 * worn**1.5 * strength))
            start = end + rng.uniform(-0.2, 0.5)
        for _ in range(3):
            start = rng.uniform(-4.0, 2.8)
            points = _arched(height + 1.5 / count + rng.normal(0, 0.06), start, start + rng.uniform(0.8, 2.0))
            lines.append(Line(_curve(points, rng, 0.03, 0.02), 0.04, 0.45, 0.4, 0.15 * worn**2, layer=1))
    return lines


def _arched(height: float, start: float, end: float) -> list[tuple[float, float]]:
    """A line across the forehead: highest over the arches of the brows, lower in the middle and at the temples."""
    return [(x, height + 0.15 * np.cos((abs(x) - 2.4) * 1.15)) for x in np.linspace(start, end, 7)]


def _nose_root(rng: Generator, worn: float) -> list[Line]:
    """Across the root of the nose."""
    high = [(-0.85, 1.25), (0.0, 1.42), (0.85, 1.25)]
    low = [(-0.7, 0.72), (0.0, 0.9), (0.7, 0.72)]
    return [
        Line(_curve(high, rng), 0.075, 0.9, 0.5, 0.2 * worn**2),
        Line(_curve(low, rng), 0.055, 0.6, 0.45),
    ]


def _frown(rng: Generator, worn: float) -> list[Line]:
    """Upright lines between the brows: a long one that leans to the temple, a fine one beside it."""
    x, top = 0.52 + rng.normal(0, 0.06), 3.75 + rng.normal(0, 0.25)
    long = [(x - 0.03, 1.75), (x, 2.5), (x + 0.16, top)]
    fine = [(x + 0.55, 2.35), (x + 0.62, 2.9), (x + 0.72, 3.45)]
    return [
        Line(_curve(long, rng), 0.085, 1.0, 0.5, 0.34 * worn**1.5, layer=1),
        Line(_curve(fine, rng), 0.05, 0.7, 0.5, 0.1 * worn**2, layer=1),
    ]


def _nose(rng: Generator) -> list[Line]:
    """Short ones that run down the side of the nose, which sneering folds."""
    return [
        Line(_curve([(0.30, 0.42 - fall), (0.62, 0.22 - fall), (1.02, -0.18 - fall)], rng), 0.05, 0.85, 0.5)
        for fall in (0.0, 0.36, 0.74)
    ]


def _eye(rng: Generator, worn: float) -> list[Line]:
    """The fan at the outer corner, fine lines between its lines, and those that follow the lower lid."""
    lines = []
    for n, angle in enumerate((44, 24, 6, -14, -34)):
        main = angle + rng.normal(0, 4)
        outer = 0.75 if n in (0, 4) else 1.0
        permanent = 0.36 * worn**1.3 * outer
        lines.append(
            Line(_ray(main, 0.30 + 0.2 * rng.random(), rng.uniform(1.2, 2.0), rng), 0.05, outer, 0.5, permanent)
        )
        fine = _ray(main - 9, 0.6 + 0.4 * rng.random(), rng.uniform(1.2, 1.7), rng)
        lines.append(Line(fine, 0.034, 0.45, 0.4, 0.12 * worn, layer=1))
    for n in range(3):
        x, y = 1.80 + 0.22 * n, -0.30 - 0.21 * n
        points = [(x, y + 0.14), (2.7, y - 0.12), (3.5, y - 0.08), (4.25 + 0.1 * n, y + 0.22)]
        lines.append(Line(_curve(points, rng), 0.042 + 0.012 * n, 0.7, 0.4, 0.35 * worn))
    return lines


def _ray(angle: float, near: float, far: float, rng: Generator) -> Points:
    """A line of the fan: from the corner of the eye, and away from the middle line of the fan."""
    turn = np.radians(angle)
    radii = np.linspace(near, far, 4)
    curl = turn * (1 + 0.12 * (radii - near))
    # The temple falls away: what lies a centimetre on is half of one to the side.
    return _curve(list(zip(4.72 + 0.8 * radii * np.cos(curl), 0.40 + radii * np.sin(curl), strict=True)), rng, 0.03)


def _cheek(rng: Generator, worn: float) -> list[Line]:
    """From the wing of the nose to beside the mouth, one soft crease; further out the smile's; down from the corner."""
    fold = [(1.75, -2.75), (2.25, -3.45), (2.80, -4.45), (3.18, -5.5), (3.30, -6.25)]
    smile = [(4.0, -3.7), (4.5, -4.6), (4.6, -5.6)]
    down = [(2.80, -6.55), (3.0, -7.2), (2.98, -7.9)]
    return [
        Line(_curve(fold, rng, 0.04, 0.012), 0.24, 1.0, 0.34, 0.08 + 0.40 * worn),
        Line(_curve(smile, rng), 0.20, 0.55, 0.3, 0.08 * worn, layer=1),
        Line(_curve(down, rng), 0.11, 0.7, 0.4, 0.3 * worn**2),
    ]


def _mouth(rng: Generator, worn: float) -> list[Line]:
    """Fine upright lines above and below the lips, and the groove over the chin."""
    lines = [Line(_curve([(-1.4, -8.0), (0.0, -7.82), (1.4, -8.0)], rng), 0.14, 0.7, 0.3, 0.1)]
    for top, bottom, count in ((-4.62, -5.40, 11), (-7.15, -7.62, 7)):
        for x in np.linspace(-1.9, 1.9, count) + rng.normal(0, 0.06, count):
            lean = 0.10 * x
            points = [(x - lean, top + 0.08 * abs(x)), (x, (top + bottom) / 2), (x + lean, bottom - 0.08 * abs(x))]
            lines.append(Line(_curve(points, rng), 0.036, 0.55, 0.4, 0.3 * max(worn - 0.35, 0.0), layer=1))
    return lines


def _neck(rng: Generator, worn: float) -> list[Line]:
    """Rings around the throat, that everybody has."""
    rings = [(-12.7, 4.0), (-14.3, 4.6)]
    return [
        Line(
            _curve([(-x, y + 0.4), (-0.4 * x, y), (0.4 * x, y), (x, y + 0.4)], rng, 0.1),
            0.12,
            0.6,
            0.3,
            0.2 + 0.3 * worn,
        )
        for y, x in rings
    ]


def _curve(points: list[tuple[float, float]], rng: Generator, shift: float = 0.05, wobble: float = 0.015) -> Points:
    """A smooth curve near some points that wavers a little, with a point for every tenth of a centimetre."""
    corners = np.array(points) + rng.normal(0, shift, 2) + rng.normal(0, 0.4 * shift, (len(points), 2))
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    at = np.linspace(0, along[-1], max(int(along[-1] / 0.1), 4))
    curve: Points = PchipInterpolator(along, corners)(at)
    across = np.gradient(curve, axis=0)[:, ::-1] * [-1, 1]
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    phases = rng.uniform(0, 2 * np.pi, 3)
    waves = sum(
        np.sin(2 * np.pi * at / length + phase) * length for length, phase in zip((2.3, 1.1, 0.6), phases, strict=True)
    )
    return curve + 0.5 * wobble * np.asarray(waves)[:, None] * across
