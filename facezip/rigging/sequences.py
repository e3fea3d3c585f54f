"""Short sequences of blends β to look at: a smile that grows, a blink, speech; from key poses to frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

# Frames from one key pose to the next; in a third of a second, as fast as a mouth speaks.
STEPS = 4


@dataclass(frozen=True)
class Pose:
    """A named blend.

    Attributes
    ----------
    name : what a viewer calls it.
    weights : β by name of an expression or shape; what is not named is zero.
    """

    name: str
    weights: Mapping[str, float]


def both(**weights: float) -> dict[str, float]:
    """ARKit weights of both sides for a name that ends in ``_``."""
    sides = {name: ("Left", "Right") if name.endswith("_") else ("",) for name in weights}
    return {f"{name.rstrip('_')}{side}": weights[name] for name in weights for side in sides[name]}


NEUTRAL = Pose("neutral", {})
ARKIT = (
    Pose("half a smile", both(mouthSmile_=0.45, cheekSquint_=0.3)),
    Pose("smile", both(mouthSmile_=0.9, cheekSquint_=0.6, eyeSquint_=0.35)),
    Pose("smile and blink", both(mouthSmile_=0.6, cheekSquint_=0.4, eyeBlink_=1.0)),
    Pose("brows up", both(browInnerUp=0.9, browOuterUp_=0.8, eyeWide_=0.4)),
    Pose("speech: ah", both(jawOpen=0.55, mouthLowerDown_=0.3, browInnerUp=0.2)),
    Pose("speech: oo", both(mouthPucker=0.7, mouthFunnel=0.3, jawOpen=0.1)),
    Pose("speech: ee", both(mouthStretch_=0.5, mouthSmile_=0.3, jawOpen=0.15)),
    Pose("speech: mm", both(mouthPress_=0.6, mouthRollLower=0.3)),
    Pose("frown and sneer", both(browDown_=0.9, noseSneer_=0.6, mouthFrown_=0.4)),
)
EMBEDDED = (
    Pose("half a smile", {"smile": 0.5}),
    Pose("smile", {"smile": 1.0}),
    Pose("smile and blink", {"smile": 0.7, "blink": 1.0}),
    Pose("brows up", {"brows_up": 1.0}),
    Pose("speech: ah", {"jaw_open": 0.6, "brows_up": 0.2}),
    Pose("speech: oo", {"pucker": 0.7, "funnel": 0.3}),
    Pose("speech: ee", {"smile": 0.3, "jaw_open": 0.2}),
    Pose("speech: mm", {"lip_roll": 0.6}),
    Pose("frown and sneer", {"frown": 0.7, "sneer_right": 0.4}),
)


def poses_for(expressions: Sequence[str]) -> tuple[Pose, ...]:
    """The key poses that these names can make: ARKit's, the embedded character's, or each expression and pairs."""
    for preset in (ARKIT, EMBEDDED):
        if all(name in expressions for pose in preset for name in pose.weights):
            return preset
    whole = [Pose(name, {name: 1.0}) for name in expressions]
    pairs = [Pose(f"{one} and {other}", {one: 0.5, other: 0.5}) for one, other in pairwise(expressions)]
    return (*whole, *pairs)


def frames_of(poses: Sequence[Pose], count: int | None = None) -> list[Pose]:
    """A closed loop from the neutral through every pose and back, easing in and out of each.

    Parameters
    ----------
    poses : K key poses.
    count : frames of the loop, at least 2; :data:`STEPS` from pose to pose if None.

    Returns
    -------
    Frames, named by the key pose that is nearest; the first one is the neutral.
    """
    keys = [NEUTRAL, *poses, NEUTRAL]
    count = STEPS * (len(keys) - 1) if count is None else count
    places = np.arange(count) * (len(keys) - 1) / count
    return [_between(keys[int(at)], keys[int(at) + 1], float(at % 1)) for at in places]


def _between(one: Pose, other: Pose, share: float) -> Pose:
    eased = share * share * (3 - 2 * share)
    names = dict.fromkeys([*one.weights, *other.weights])
    mixed = {name: (1 - eased) * one.weights.get(name, 0) + eased * other.weights.get(name, 0) for name in names}
    return Pose((other if share >= 0.5 else one).name, {name: value for name, value in mixed.items() if value > 0})
