"""The 52 ARKit shapes as displacements of the neutral head: muscles that pull, a jaw that turns, lids that close."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from scenes.face.features import MOUTH_HALF_WIDTH, lip_line
from scenes.face.head import Head
from scenes.face.lids import gaze, lids
from scenes.face.steps import smooth_step

Field = NDArray[np.float64]
JAW_JOINT = np.array([0.0, -1.2, -0.3])
JAW_OPEN = np.radians(17.0)


@dataclass(frozen=True)
class Pull:
    """A muscle: a smooth displacement (cm) around a point (cm), on the character's left side."""

    centre: tuple[float, float, float]
    radius: tuple[float, float, float]
    move: tuple[float, float, float]

    def field(self, points: Field) -> Field:
        """Displacements ``(V, 3)``."""
        reach = (points - self.centre) / np.array(self.radius)
        return np.exp(-np.sum(reach * reach, axis=1))[:, None] * np.array(self.move)


SIDED = {
    "browDown": [
        Pull((1.9, 2.6, 8.2), (2.0, 1.6, 3), (-0.56, -0.50, 0.12)),
        Pull((3.8, 2.8, 7), (1.6, 1.3, 3), (-0.1, -0.3, 0)),
    ],
    "browOuterUp": [Pull((4.0, 2.9, 7.2), (2.0, 2.2, 3), (0.06, 0.85, -0.05))],
    "cheekSquint": [
        Pull((3.7, -1.5, 7.2), (2.0, 1.5, 3), (-0.05, 0.52, 0.16)),
        Pull((5.0, 0.2, 5.6), (1.2, 1.4, 2), (-0.28, 0.05, 0.1)),
    ],
    "mouthDimple": [Pull((2.5, -6.1, 8.0), (1.3, 1.3, 2), (0.34, 0.06, -0.42))],
    "mouthFrown": [Pull((2.4, -6.2, 8.0), (1.5, 1.7, 2.5), (0.14, -0.68, -0.1))],
    "mouthPress": [Pull((2.2, -6.1, 8.2), (1.2, 1.0, 2), (0.12, 0.05, -0.12))],
    "mouthSmile": [
        Pull((2.5, -6.0, 8.0), (1.6, 1.6, 2.5), (0.68, 0.62, -0.50)),
        Pull((3.7, -2.9, 7.0), (1.7, 1.7, 2.5), (0.08, 0.46, 0.22)),
        Pull((4.8, 0.0, 5.8), (1.1, 1.1, 2.0), (-0.12, 0.08, 0.05)),
    ],
    "mouthStretch": [Pull((2.6, -6.4, 7.8), (1.9, 1.7, 2.5), (0.72, -0.28, -0.36))],
    "noseSneer": [
        Pull((1.35, -2.4, 8.9), (1.1, 1.6, 2.5), (0.10, 0.50, -0.05)),
        Pull((1.5, -5.0, 8.6), (1.1, 0.9, 2.5), (0.06, 0.36, 0.05)),
        Pull((0.9, 1.6, 8.2), (1.1, 1.1, 2.5), (-0.16, -0.16, 0.06)),
    ],
}  # fmt: skip

CENTRAL = {
    "browInnerUp": [Pull((0.0, 2.9, 8.4), (2.6, 2.4, 3.5), (0.0, 0.88, 0.0))],
    "mouthShrugLower": [Pull((0.0, -8.3, 8.4), (2.0, 1.7, 3.0), (0.0, 0.62, 0.18))],
    "mouthShrugUpper": [Pull((0.0, -5.2, 9.0), (2.0, 0.9, 3.0), (0.0, 0.36, 0.20))],
}

ARKIT_SHAPES = (
    "browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft", "browOuterUpRight", "cheekPuff",
    "cheekSquintLeft", "cheekSquintRight", "eyeBlinkLeft", "eyeBlinkRight", "eyeLookDownLeft", "eyeLookDownRight",
    "eyeLookInLeft", "eyeLookInRight", "eyeLookOutLeft", "eyeLookOutRight", "eyeLookUpLeft", "eyeLookUpRight",
    "eyeSquintLeft", "eyeSquintRight", "eyeWideLeft", "eyeWideRight", "jawForward", "jawLeft", "jawOpen", "jawRight",
    "mouthClose", "mouthDimpleLeft", "mouthDimpleRight", "mouthFrownLeft", "mouthFrownRight", "mouthFunnel",
    "mouthLeft", "mouthLowerDownLeft", "mouthLowerDownRight", "mouthPressLeft", "mouthPressRight", "mouthPucker",
    "mouthRight", "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "mouthSmileLeft",
    "mouthSmileRight", "mouthStretchLeft", "mouthStretchRight", "mouthUpperUpLeft", "mouthUpperUpRight",
    "noseSneerLeft", "noseSneerRight", "tongueOut",
)  # fmt: skip


def shape_deltas(head: Head) -> NDArray[np.float32]:
    """Displacements ``(52, V, 3)`` in cm at weight 1, in the order of :data:`ARKIT_SHAPES`."""
    points = head.vertices.astype(np.float64)
    skin = _skin(points)[:, None]
    fields = _central(head, points)
    for name, pulls in SIDED.items():
        _add_sides(fields, name, points, partial(_pulled, pulls, skin))
    _add_sides(fields, "mouthLowerDown", points, lambda p: _lip(head, p, (1.2, -6.9, 8.7), (0.05, -0.62, -0.06), True))
    _add_sides(fields, "mouthUpperUp", points, lambda p: _lip(head, p, (1.2, -5.6, 8.8), (0.04, 0.52, 0.06), False))
    fields |= lids(head) | gaze(head)
    return np.stack([fields[name] for name in ARKIT_SHAPES]).astype(np.float32)


def _pulled(pulls: list[Pull], skin: Field, points: Field) -> Field:
    return np.sum([pull.field(points) for pull in pulls], axis=0) * skin


def _add_sides(fields: dict[str, Field], name: str, points: Field, field: Callable[[Field], Field]) -> None:
    mirror = np.array([-1.0, 1.0, 1.0])
    fields[f"{name}Left"] = field(points)
    fields[f"{name}Right"] = field(points * mirror) * mirror


def _central(head: Head, points: Field) -> dict[str, Field]:
    skin = _skin(points)[:, None]
    fields = {name: _pulled(pulls, skin, points) for name, pulls in CENTRAL.items()}
    jaw = jaw_weight(head, points)[:, None]
    mouth = np.exp(-np.sum(((points - [0, -6.1, 8.6]) / [2.7, 1.7, 3.0]) ** 2, axis=1))[:, None]
    over = (points[:, 1] - lip_line(points[:, 0]))[:, None]
    x = points[:, :1]
    zero = np.zeros_like(x)
    opened = _turned(points, JAW_OPEN) * jaw
    pucker = mouth * np.hstack([-0.42 * x, -0.10 * over, 0.75 + zero])
    lower = _below(head, points, 1.9, 0.5)[:, None]
    funnel = mouth * np.hstack([-0.30 * x, 0.28 - 0.58 * lower, 0.62 + zero])
    roll = mouth * np.hstack([zero, -0.35 * over, -0.32 + zero])
    cheek = np.exp(-np.sum(((np.abs(points) - [4.2, 5.0, 6.0]) / [1.9, 2.1, 3.0]) ** 2, axis=1)) * (points[:, 2] > 0)
    fields |= {
        "jawOpen": opened,
        "jawForward": jaw * [0, 0, 0.55],
        "jawLeft": jaw * [0.65, 0, 0],
        "jawRight": jaw * [-0.65, 0, 0],
        "mouthPucker": pucker,
        "mouthFunnel": funnel,
        "mouthRollLower": roll * lower,
        "mouthRollUpper": roll * (1 - lower),
        "mouthClose": mouth**0.7 * (0.30 - 0.98 * jaw) * _turned(points, JAW_OPEN) * [0, 1, 0.6],
        "mouthLeft": mouth * np.hstack([0.75 + zero, 0 * x, -0.02 * x]),
        "mouthRight": mouth * np.hstack([-0.75 + zero, 0 * x, 0.02 * x]),
        "cheekPuff": cheek[:, None] * np.hstack([0.75 * np.sign(x), zero, 0.45 + zero]),
        "tongueOut": _tongue(head, points),
    }
    return fields


def jaw_weight(head: Head, points: Field) -> NDArray[np.float64]:
    """``(V,)`` how much of the jaw's motion a point follows: all of it below the lips, none above, shared beside."""
    _, y, z = points.T
    neck = smooth_step((y + 0.22 * np.maximum(z - 1, 0) + 13.0) / 3.8)
    return _below(head, points, 0.9, 1.4) * neck * smooth_step((z + 1.5) / 6.5) * smooth_step((-1.6 - y) / 3.5)


def _turned(points: Field, angle: float) -> Field:
    """Displacement of a rotation of the jaw about its joint, opening for positive angles (radians)."""
    y, z = (points - JAW_JOINT)[:, 1], (points - JAW_JOINT)[:, 2]
    turned_y, turned_z = np.cos(angle) * y - np.sin(angle) * z, np.sin(angle) * y + np.cos(angle) * z
    return np.stack([np.zeros_like(y), turned_y - y, turned_z - z], axis=1)


def _lip(
    head: Head, points: Field, centre: tuple[float, float, float], move: tuple[float, float, float], lower: bool
) -> Field:
    below = _below(head, points, 1.9, 0.5)
    side = below if lower else 1 - below
    return Pull(centre, (1.15, 1.1, 2.5), move).field(points) * side[:, None]


def _tongue(head: Head, points: Field) -> Field:
    """The dark back of the mouth comes forward as a tongue."""
    row = (head.rows.lower_lip + head.rows.upper_lip) // 2
    rows = np.arange(len(points)) // head.shape[1]
    inside = _in_pocket(head) * np.exp(-(((rows - row) / 1.2) ** 2)) * np.exp(-((points[:, 0] / 1.2) ** 2))
    return inside[:, None] * np.array([0.0, -0.35, 3.4])


def _below(head: Head, points: Field, start: float, fade: float) -> NDArray[np.float64]:
    """1 under the line of the lips, 0 above; in the pocket, by the rows of the grid.

    The step is sharp between the lips, softens from ``|x| = start`` on, and is ``fade`` cm wide (growing outwards) at
    and beyond the corners of the mouth.
    """
    x, pocket = np.abs(points[:, 0]), _in_pocket(head)
    rows = np.arange(len(points)) // head.shape[1]
    middle = (head.rows.lower_lip + head.rows.upper_lip) / 2
    over = np.where(pocket, 0.0, points[:, 1] - lip_line(np.minimum(x, MOUTH_HALF_WIDTH)))
    sharp = np.where(pocket, np.clip((middle + 1 - rows) / 2, 0, 1), over < 0)
    beyond = np.maximum(x - MOUTH_HALF_WIDTH, 0) + 0.3 * np.maximum(6.0 - points[:, 2], 0)
    soft = smooth_step(0.5 - over / (2 * fade + 1.2 * beyond))
    return sharp + smooth_step((x - start) / (MOUTH_HALF_WIDTH - start)) * (soft - sharp)


def _in_pocket(head: Head) -> NDArray[np.bool_]:
    grid = head.grid(head.vertices)
    pocket = np.zeros(head.shape, bool)
    inside = (np.abs(grid[head.rows.lower_lip, :, 0]) < MOUTH_HALF_WIDTH) & (grid[head.rows.lower_lip, :, 2] > 5)
    pocket[head.rows.lower_lip : head.rows.upper_lip + 1, inside] = True
    return pocket.ravel()


def _skin(points: Field) -> NDArray[np.float64]:
    """Muscles move the face, not the back of the head or the inside of the mouth."""
    return smooth_step((points[:, 2] - 0.5) / 3.0)
