"""What an expression does to the albedo: folds across the compression, and blood that is pressed in or out."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.head import Head
from scenes.face.skin.noise import smooth, value_noise
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strain import Strain
from scenes.face.skin.zones import propensity

TAPS = 13


def wrinkled(albedo: NDArray[np.float32], head: Head, skin_strain: Strain, seed: int) -> NDArray[np.float32]:
    """The albedo ``(R, R, 3)`` under a strain; equal to ``albedo`` where there is none.

    Folds lie where the person's own noise, smeared along the direction in which wrinkles run, crosses zero: so they
    keep their places from expression to expression, and run at right angles to the compression.
    """
    resolution = len(albedo)
    texels = TexelGrid.of(head, resolution)
    fields = fields_of(skin_strain)
    out = albedo.copy()

    def fold(top: int, bottom: int) -> None:
        _fold(top, bottom, texels, fields, seed, out)

    map_rows(fold, resolution)
    return out


def fields_of(skin_strain: Strain) -> NDArray[np.float32]:
    """Compression, change of area, and the lines of wrinkles: ``(rows, columns, 8)``, to be interpolated."""
    return np.concatenate(
        [skin_strain.compression[..., None], skin_strain.area[..., None], _outer(skin_strain.line)], axis=2
    ).astype(np.float32)


def _outer(line: NDArray[np.float32]) -> NDArray[np.float32]:
    """Lines without a sign, ``(..., 6)``: products of their components, which may be interpolated."""
    return np.stack([line[..., a] * line[..., b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], axis=-1)


@kernel()
def _fold(
    top: int,
    bottom: int,
    texels: TexelGrid,
    fields: NDArray[np.float32],
    seed: int,
    out: NDArray[np.float32],
) -> None:
    p, f = np.empty(3), np.empty(8)
    for j in range(top, bottom):
        for i in range(len(texels.column_of)):
            at_texel(fields, texels.row_of[j], texels.column_of[i], f)
            if f[0] < 0.004 and abs(f[1]) < 0.004:
                continue
            at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
            strength, spacing = propensity(p[0], p[1], p[2])
            pressed = max(-f[1], 0.0)
            stretched = max(f[1], 0.0)
            depth = depth_of(strength, f[0])
            groove, ridge = 0.0, 0.0
            if depth > 0.01:
                groove, ridge = folds(p, f, spacing, texels.texel, seed)
            # Grooves are dark and red, their crests bright; pressed skin flushes, stretched skin pales.
            flush = 0.55 * (1 - np.exp(-3.0 * pressed))
            pale = 0.35 * (1 - np.exp(-2.0 * stretched))
            dark = 0.38 * depth * groove
            light = 0.07 * depth * ridge + 0.05 * pale
            out[j, i, 0] = min(out[j, i, 0] * (1 - 0.88 * dark) * (1 - 0.05 * flush) * (1 + light), 1.0)
            out[j, i, 1] = min(out[j, i, 1] * (1 - 1.02 * dark) * (1 - 0.22 * flush) * (1 + light + 0.06 * pale), 1.0)
            out[j, i, 2] = min(out[j, i, 2] * (1 - 1.02 * dark) * (1 - 0.20 * flush) * (1 + light + 0.06 * pale), 1.0)


@inner()
def depth_of(strength: float, compression: float) -> float:
    """How deep skin folds, 0..1, under a compression; a little of it raises no fold."""
    return strength * (1 - np.exp(-5.0 * max(compression - 0.035, 0.0)))


@kernel()
def folds(
    p: NDArray[np.float64], f: NDArray[np.float64], spacing: float, texel: float, seed: int
) -> tuple[float, float]:
    """How much of a groove and of a crest a point lies on, each in [0, 1], long folds and fine ones together."""
    # The dominant direction of the interpolated products: the column with the largest diagonal.
    if f[2] >= f[3] and f[2] >= f[4]:
        d0, d1, d2 = f[2], f[5], f[6]
    elif f[3] >= f[4]:
        d0, d1, d2 = f[5], f[3], f[7]
    else:
        d0, d1, d2 = f[6], f[7], f[4]
    length = max(np.sqrt(d0 * d0 + d1 * d1 + d2 * d2), 1e-9)
    d = d0 / length, d1 / length, d2 / length
    # Across the line, along the skin: the normal of a head points away from its axis, nearly.
    a0, a1, a2 = p[2] * d[1] - 0.3 * p[1] * d[2], -p[2] * d[0] + p[0] * d[2], 0.3 * p[1] * d[0] - p[0] * d[1]
    length = max(np.sqrt(a0 * a0 + a1 * a1 + a2 * a2), 1e-9)
    # Where wrinkles lie closely, their direction turns within a few of them.
    reach = 1.3 + 2.4 * smooth(0.7, 0.95, spacing)
    groove, ridge = 0.0, 0.0
    for octave in range(2):
        size = spacing * (1.0 if octave == 0 else 0.42)
        visible = smooth(1.2 * texel, 2.5 * texel, 0.35 * size)
        step = 0.12 * size / length
        one = _smeared(p[0] - step * a0, p[1] - step * a1, p[2] - step * a2, d, reach, size, seed + 301 + octave)
        other = _smeared(p[0] + step * a0, p[1] + step * a1, p[2] + step * a2, d, reach, size, seed + 301 + octave)
        n, slope = 0.5 * (one + other), abs(other - one) / 0.24
        # As wide everywhere, and only where the noise changes across the line: where zeros turn, a fold runs out.
        away = n / max(slope, 0.04)
        present = smooth(0.08, 0.28, slope)
        width = 0.10 + 0.35 * texel / size
        share = 1.0 if octave == 0 else 0.30
        groove += visible * share * present * np.exp(-((away / width) ** 2))
        ridge += visible * share * present * np.exp(-(((abs(away) - 2.6 * width) / width) ** 2))
    return min(groove, 1.0), min(ridge, 1.0)


@inner()
def _smeared(
    x: float, y: float, z: float, d: tuple[float, float, float], reach: float, size: float, seed: int
) -> float:
    """Noise with features of ``size`` cm, smeared along ``d`` as far as ``reach`` features both ways."""
    total = 0.0
    for tap in range(TAPS):
        t = (tap - TAPS // 2) / (TAPS // 2) * reach
        total += value_noise(x / size + t * d[0], y / size + t * d[1], z / size + t * d[2], seed)
    return total / TAPS
