"""Named camera views that frame a head, in any unit and at any scale."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.plugins import Plugin


@dataclass(frozen=True)
class View:
    """A camera on a sphere around the face.

    Attributes
    ----------
    name : what reports call it.
    azimuth, elevation : degrees from straight ahead (+z); positive azimuth sees the character's left side (+x).
    extent : height of the picture in units of the head's height.
    aim : point looked at, in units of the head's height above (y) and to the left (x) of its centre.
    """

    name: str
    azimuth: float = 0.0
    elevation: float = 0.0
    extent: float = 1.08
    aim: tuple[float, float] = (0.0, 0.0)


# In the order in which `--views N` takes them.
VIEWS = (
    View("front", elevation=4),
    View("three_quarter_left", azimuth=38, elevation=6),
    View("three_quarter_right", azimuth=-38, elevation=6),
    View("close_up", azimuth=12, elevation=2, extent=0.48, aim=(0.0, 0.06)),
    View("profile", azimuth=82, elevation=2),
)

# A portrait lens: far enough away that noses do not grow.
FIELD_OF_VIEW = 18.0


@dataclass(frozen=True)
class Frame:
    """Where a head is: the centre of its bounding box and its height, in the mesh's unit."""

    centre: tuple[float, float, float]
    height: float


def frame_of(vertices: NDArray[np.float32]) -> Frame:
    """The frame of neutral vertices ``(V, 3)``, y up, face to +z."""
    low, high = vertices.min(axis=0).astype(float), vertices.max(axis=0).astype(float)
    x, y, z = ((low + high) / 2).tolist()
    return Frame((x, y, z), float(high[1] - low[1]))


def placement(view: View, frame: Frame) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where a view's camera stands and what it looks at, ``(3,)`` each, in the mesh's unit."""
    azimuth, elevation = np.radians(view.azimuth), np.radians(view.elevation)
    direction = [np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)]
    target = np.array(frame.centre) + np.array([view.aim[0], view.aim[1], 0.0]) * frame.height
    distance = view.extent * frame.height / (2 * np.tan(np.radians(FIELD_OF_VIEW) / 2))
    return target + distance * np.array(direction), target


def camera(view: View, frame: Frame, resolution: int) -> Plugin:
    """A Mitsuba ``perspective`` sensor dict of ``resolution`` x ``resolution`` pixels with a box filter."""
    return {
        "type": "perspective",
        "fov": FIELD_OF_VIEW,
        "to_world": look_at(*placement(view, frame)),
        "film": {
            "type": "hdrfilm",
            "width": resolution,
            "height": resolution,
            "pixel_format": "rgba",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "multijitter"},
    }


def pixel_bounds(view: View, frame: Frame, resolution: int, vertices: NDArray[np.float32]) -> tuple[int, int, int, int]:
    """First column and row, and width and height, of the pixels that vertices ``(V, 3)`` can fall on."""
    origin, target = placement(view, frame)
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, -np.cross(right, forward), forward])
    x, y, depth = axes @ (vertices.astype(np.float64) - origin).T
    if depth.min() <= 0:
        return 0, 0, resolution, resolution
    pixels = resolution * (0.5 + np.stack([x, y]) / depth / (2 * np.tan(np.radians(FIELD_OF_VIEW) / 2)))
    low = np.clip(np.floor(pixels.min(axis=1)) - 1, 0, resolution - 1).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=1)) + 1, low + 1, resolution).astype(int)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def look_at(origin: NDArray[np.float64], target: NDArray[np.float64]) -> Any:
    """A Mitsuba transform whose +z axis points from ``origin`` to ``target``, y up; needs a variant to be set."""
    import mitsuba as mi

    up = [0, 1, 0] if abs((target - origin)[1]) < 0.99 * np.linalg.norm(target - origin) else [0, 0, 1]
    return mi.ScalarTransform4f().look_at(origin=origin.tolist(), target=target.tolist(), up=up)
