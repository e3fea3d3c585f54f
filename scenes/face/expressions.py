"""Twenty named expressions of one person, as blends of the ARKit shapes."""

import numpy as np

from scenes.face.shapes import ARKIT_SHAPES


def _both(**weights: float) -> dict[str, float]:
    """Weights of shapes that exist for both sides, as for ``mouthSmile=1``, or for one, as for ``jawOpen=1``."""
    named: dict[str, float] = {}
    for name, weight in weights.items():
        names = [name] if name in ARKIT_SHAPES else [f"{name}Left", f"{name}Right"]
        named |= dict.fromkeys(names, weight)
    return named


EXPRESSIONS: dict[str, dict[str, float]] = {
    "smile": _both(mouthSmile=0.85, cheekSquint=0.55, eyeSquint=0.35, mouthDimple=0.25),
    "laugh": _both(mouthSmile=1.0, cheekSquint=0.95, eyeSquint=0.7, jawOpen=0.42, mouthUpperUp=0.45, noseSneer=0.25),
    "brows_up": _both(browInnerUp=1.0, browOuterUp=1.0, eyeWide=0.45),
    "frown": _both(browDown=1.0, eyeSquint=0.4, mouthPress=0.5, mouthFrown=0.25, noseSneer=0.15),
    "surprise": _both(browInnerUp=0.85, browOuterUp=0.95, eyeWide=1.0, jawOpen=0.55, mouthFunnel=0.25),
    "sad": _both(browInnerUp=0.9, browDown=0.25, mouthFrown=0.9, mouthShrugLower=0.55, eyeBlink=0.22),
    "anger": _both(browDown=1.0, noseSneer=0.65, eyeSquint=0.5, mouthPress=0.6, jawForward=0.4, mouthFrown=0.4),
    "disgust": _both(noseSneer=1.0, mouthUpperUp=0.75, browDown=0.55, cheekSquint=0.6, mouthFrown=0.3),
    "fear": _both(browInnerUp=1.0, browOuterUp=0.4, browDown=0.3, eyeWide=0.9, mouthStretch=0.8, jawOpen=0.22),
    "blink": _both(eyeBlink=1.0),
    "squeeze": _both(eyeBlink=0.6, eyeSquint=1.0, cheekSquint=1.0, browDown=0.85, noseSneer=0.6, mouthPress=0.3),
    "pucker": _both(mouthPucker=1.0),
    "funnel": _both(mouthFunnel=1.0, jawOpen=0.2),
    "jaw_open": _both(jawOpen=1.0),
    "cheek_puff": _both(cheekPuff=1.0, mouthPress=0.4, mouthPucker=0.2),
    "chin_raise": _both(mouthShrugLower=1.0, mouthShrugUpper=0.6, mouthFrown=0.45),
    "lip_roll": _both(mouthRollLower=1.0, mouthRollUpper=1.0, mouthPress=0.6),
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
