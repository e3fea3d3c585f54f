"""Twenty named expressions of one person, as blends of the ARKit shapes."""

import numpy as np

from facezip.rigging.sequences import both
from scenes.face.shapes import ARKIT_SHAPES

EXPRESSIONS: dict[str, dict[str, float]] = {
    "smile": both(mouthSmile_=0.85, cheekSquint_=0.55, eyeSquint_=0.35, mouthDimple_=0.25),
    "laugh": both(
        mouthSmile_=1.0, cheekSquint_=0.95, eyeSquint_=0.7, jawOpen=0.42, mouthUpperUp_=0.45, noseSneer_=0.25
    ),
    "brows_up": both(browInnerUp=1.0, browOuterUp_=1.0, eyeWide_=0.45),
    "frown": both(browDown_=1.0, eyeSquint_=0.4, mouthPress_=0.5, mouthFrown_=0.25, noseSneer_=0.15),
    "surprise": both(browInnerUp=0.85, browOuterUp_=0.95, eyeWide_=1.0, jawOpen=0.55, mouthFunnel=0.25),
    "sad": both(browInnerUp=0.9, browDown_=0.25, mouthFrown_=0.9, mouthShrugLower=0.55, eyeBlink_=0.22),
    "anger": both(browDown_=1.0, noseSneer_=0.65, eyeSquint_=0.5, mouthPress_=0.6, jawForward=0.4, mouthFrown_=0.4),
    "disgust": both(noseSneer_=1.0, mouthUpperUp_=0.75, browDown_=0.55, cheekSquint_=0.6, mouthFrown_=0.3),
    "fear": both(browInnerUp=1.0, browOuterUp_=0.4, browDown_=0.3, eyeWide_=0.9, mouthStretch_=0.8, jawOpen=0.22),
    "blink": both(eyeBlink_=1.0),
    "squeeze": both(eyeBlink_=0.6, eyeSquint_=1.0, cheekSquint_=1.0, browDown_=0.85, noseSneer_=0.6, mouthPress_=0.3),
    "pucker": both(mouthPucker=1.0),
    "funnel": both(mouthFunnel=1.0, jawOpen=0.2),
    "jaw_open": both(jawOpen=1.0),
    "cheek_puff": both(cheekPuff=1.0, mouthPress_=0.4, mouthPucker=0.2),
    "chin_raise": both(mouthShrugLower=1.0, mouthShrugUpper=0.6, mouthFrown_=0.45),
    "lip_roll": both(mouthRollLower=1.0, mouthRollUpper=1.0, mouthPress_=0.6),
    "smirk_left": {"mouthSmileLeft": 1.0, "cheekSquintLeft": 0.6, "mouthDimpleLeft": 0.5, "browOuterUpRight": 0.5},
    "wink_right": {"eyeBlinkRight": 1.0, "cheekSquintRight": 0.9, "mouthSmileRight": 0.55, "browDownRight": 0.5},
    "sneer_right": {"noseSneerRight": 1.0, "mouthUpperUpRight": 0.9, "browDownRight": 0.6, "browOuterUpLeft": 0.7},
}


def expression_weights(count: int, seed: int) -> dict[str, dict[str, float]]:
    """The first ``count`` expressions; beyond the twenty, seeded compounds of three to six shapes."""
    named = dict(list(EXPRESSIONS.items())[:count])
    rng = np.random.default_rng([seed, 5])
    for n in range(len(named), count):
        shapes = rng.choice(len(ARKIT_SHAPES) - 1, rng.integers(3, 7), replace=False)
        named[f"compound_{n + 1}"] = {ARKIT_SHAPES[m]: round(float(rng.uniform(0.3, 0.9)), 2) for m in sorted(shapes)}
    return named
