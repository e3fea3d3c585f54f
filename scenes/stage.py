"""A whole scene: a head in a light rig, seen from a view."""

from typing import Any

from scenes.cameras import Frame
from scenes.lights import RIGS
from scenes.plugins import Plugin


def stage(head: Any, frame: Frame, rig: str, max_depth: int = 2) -> Plugin:
    """A Mitsuba scene dict without a camera: one head under one light rig, with direct light by default.

    Parameters
    ----------
    head : a Mitsuba shape, or the dict of one.
    frame : where the head is.
    rig : a key of :data:`scenes.lights.RIGS`.
    max_depth : of the path integrator that `mi.render` uses; 2 is direct light.
    """
    integrator = {"type": "path", "max_depth": max_depth, "hide_emitters": True}
    return {"type": "scene", "integrator": integrator, "head": head, **RIGS[rig](frame)}
