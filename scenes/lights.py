"""Light rigs around a head, as Mitsuba scene dicts."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scenes.cameras import Frame, look_at
from scenes.plugins import Plugin


def studio(frame: Frame) -> Plugin:
    """A soft key from the upper left of the camera, a broad fill, and a rim from behind: a portrait."""
    return {
        "key": _softbox("key", frame, (-0.9, 0.9, 1.5), 0.45, (16.5, 15.8, 14.8)),
        "fill": _softbox("fill", frame, (1.6, 0.1, 1.2), 0.65, (2.4, 2.5, 2.7)),
        "rim": _softbox("rim", frame, (1.2, 0.9, -1.3), 0.35, (6.0, 6.4, 7.0)),
    }


def daylight(frame: Frame) -> Plugin:
    """An overcast sky with a soft sun: light from everywhere, as outdoors."""
    import mitsuba as mi

    return {"sky": {"type": "envmap", "bitmap": mi.Bitmap(_sky()), "scale": 0.85}}


def side(frame: Frame) -> Plugin:
    """One small, hard light that rakes over the skin and reveals every wrinkle, with a trace of fill."""
    return {
        "key": _softbox("key", frame, (-1.9, 0.5, 0.55), 0.15, (190.0, 180.0, 168.0)),
        "fill": _softbox("fill", frame, (1.6, 0.2, 1.4), 0.55, (1.3, 1.35, 1.5)),
    }


# In the order in which `--lights N` takes them.
RIGS: dict[str, Callable[[Frame], Plugin]] = {"studio": studio, "side": side, "daylight": daylight}


# Farther out than any camera, so that no light stands between a camera and the head.
DISTANCE = 6.0


def _softbox(
    name: str, frame: Frame, direction: tuple[float, float, float], size: float, radiance: tuple[float, float, float]
) -> Plugin:
    """A square light that faces the head; ``size`` is its side over its distance."""
    import mitsuba as mi

    centre = np.array(frame.centre)
    origin = centre + np.array(direction) / np.linalg.norm(direction) * DISTANCE * frame.height
    scale = mi.ScalarTransform4f().scale(size * DISTANCE * frame.height / 2)
    return {
        "type": "rectangle",
        "to_world": look_at(origin, centre) @ scale,
        "emitter": {
            "type": "area",
            "sampling_weight": 2.0 if name == "key" else 1.0,
            "id": f"{name}_light",
            "radiance": {"type": "rgb", "value": list(radiance)},
        },
    }


def _sky(height: int = 64) -> NDArray[np.float32]:
    """``(height, 2·height, 3)`` linear radiance: blue above, warm ground below, a wide sun behind the camera."""
    polar = (np.arange(height) + 0.5) / height * np.pi
    azimuth = (np.arange(2 * height) + 0.5) / height * np.pi
    up = np.cos(polar)[:, None, None]
    directions = np.stack(
        np.broadcast_arrays(
            np.sin(polar)[:, None] * np.sin(azimuth), np.cos(polar)[:, None], -np.sin(polar)[:, None] * np.cos(azimuth)
        ),
        axis=2,
    )
    zenith, horizon, ground = np.array([0.42, 0.52, 0.70]), np.array([0.80, 0.84, 0.88]), np.array([0.22, 0.19, 0.16])
    sky = np.where(up > 0, horizon + (zenith - horizon) * np.abs(up) ** 0.6, ground)
    sun = directions @ (np.array([-0.45, 0.55, 0.7]) / np.linalg.norm([-0.45, 0.55, 0.7]))
    glow = 5.0 * np.exp(14 * (np.minimum(sun, 1) - 1))[..., None] * np.array([1.0, 0.93, 0.82])
    radiance: NDArray[np.float32] = (sky + glow).astype(np.float32)
    return radiance
