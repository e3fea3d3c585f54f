"""How skin shines, by its zones: roughness and specular of the neutral, and the hollows that keep light in."""

from facezip.machine.kernels import kernel
from scenes.face.skin.noise import fractal, smooth
from scenes.face.skin.zones import bump, from_lid_crease, from_mouth_line, from_nostril, lips

# Roughness and specular of what is wet: eyes; teeth and the inside of the mouth.
EYE, MOUTH = (0.20, 0.36), (0.22, 0.40)


@kernel()
def oil(x: float, y: float, z: float) -> float:
    """Where skin is oily, 0..1: the middle of the forehead, the nose, the chin."""
    front = smooth(1.0, 5.0, z)
    nose = bump(x, y, 0.0, -2.2, 1.2, 2.2) + 0.5 * bump(x, y, 1.3, -3.3, 0.7, 0.8)
    forehead, chin = 0.75 * bump(x, y, 0.0, 4.6, 3.4, 2.0), 0.55 * bump(x, y, 0.0, -9.0, 1.5, 1.1)
    lids = 0.45 * bump(x, y, 3.1, 1.2, 1.4, 0.5) + 0.25 * bump(x, y, 3.9, -1.6, 1.2, 0.9)
    return min(front * (nose + forehead + chin + lids), 1.0)


@kernel()
def roughness(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Of the neutral, as of a principled BSDF: oily skin and lips are smoother, and both are patchy."""
    patchy = 0.04 * fractal(x, y, z, 2.6, 4, texel, seed + 411) + 0.05 * fractal(x, y, z, 0.24, 3, texel, seed + 421)
    return 0.56 - 0.18 * oil(x, y, z) + patchy - 0.13 * lips(x, y, z)


@kernel()
def specular(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Of the neutral, a reflectance of 0.08 · specular: 0.35 is dry skin, oil and the moisture of lips add to it."""
    value = 0.35 + 0.17 * oil(x, y, z) + 0.03 * fractal(x, y, z, 1.7, 3, texel, seed + 431)
    return value + 0.12 * lips(x, y, z)


@kernel()
def hollow(x: float, y: float, z: float) -> float:
    """What the hollows of the face keep of a highlight, 0..1: nostrils, the line of the lips, the crease of the lid."""
    if z < 5:
        return 0.0
    kept = 0.85 * smooth(1.35, 0.7, from_nostril(x, y, z))
    kept = max(kept, 0.55 * smooth(0.16, 0.0, from_mouth_line(x, y)) * smooth(2.75, 2.3, abs(x)))
    return max(kept, 0.35 * smooth(0.22, 0.0, abs(from_lid_crease(x, y))) * smooth(1.6, 1.1, abs(abs(x) - 3.2)))
