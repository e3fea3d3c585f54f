"""What a capture adds to the truth: misregistration, sensor noise, drift of the exposure."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates, zoom

from facezip.character.maps import KNOWN, normals_of
from facezip.files.images import Texels
from scenes.face.skin.relief import Relief

# What a capture gives besides the albedo, in the order of files.
MAPS = ("normal", "roughness", "specular", "cavity")


@dataclass(frozen=True)
class Nuisances:
    """Strengths; 0 switches one off exactly.

    Attributes
    ----------
    misregistration : root mean square of a smooth UV error, in texels of a 512 x 512 texture.
    noise : standard deviation of the sensor's noise at mid grey, in units of 0..255.
    drift : standard deviation of the exposure, relative; a quarter of it a channel for the white balance.
    """

    misregistration: float = 0.55
    noise: float = 1.0
    drift: float = 0.01

    def scaled(self, strength: float) -> "Nuisances":
        """All nuisances times ``strength``."""
        return Nuisances(self.misregistration * strength, self.noise * strength, self.drift * strength)


def captured(
    texture: NDArray[np.float32], nuisances: Nuisances, rng: np.random.Generator, registered: bool = False
) -> NDArray[np.float32]:
    """A texture ``(R, R, C)`` as a capture gives it; ``registered`` ones, the neutral, are not warped."""
    if nuisances.misregistration > 0 and not registered:
        texture = _warped(texture, nuisances.misregistration * len(texture) / 512, rng)
    if nuisances.drift > 0:
        drift = rng.normal() + 0.25 * rng.normal(size=texture.shape[2])
        texture = texture * np.asarray(1 + nuisances.drift * drift, np.float32)
    if nuisances.noise > 0:
        grain = rng.standard_normal(texture.shape, np.float32) * np.float32(nuisances.noise / 255)
        texture = texture + grain * np.sqrt(0.3 + 1.4 * np.clip(texture, 0, 1))
    return np.clip(texture, 0, 1).astype(np.float32)


def captured_maps(
    truth: Relief, nuisances: Nuisances, rng: np.random.Generator, registered: bool = False
) -> dict[str, Texels]:
    """All of :data:`MAPS`, 8 bits a channel; normals as the slopes of those are fitted."""
    # Maps are solved for from photographs under many lights: exposure does not count, and noise averages out.
    steady = replace(nuisances, drift=0.0, noise=0.5 * nuisances.noise)
    encoded = np.concatenate(
        [(normals_of(truth.slopes) + 1) / 2, truth.roughness, truth.specular, truth.cavity], axis=2
    )
    seen = np.rint(captured(encoded, steady, rng, registered) * 255)
    normals = KNOWN["normal"].encode(_unit(2 * seen[..., :3] / 255 - 1))
    found: dict[str, Texels] = {"normal": np.rint(normals * 65535).astype(np.uint16)}
    for channel, name in enumerate(MAPS[1:], 3):
        found[name] = np.ascontiguousarray(seen[..., channel, None]).astype(np.uint8)
    return found


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float32]:
    length = np.sqrt(np.square(vectors).sum(axis=2, keepdims=True))
    return (vectors / np.maximum(length, 1e-6)).astype(np.float32)


def _warped(texture: NDArray[np.float32], amount: float, rng: np.random.Generator) -> NDArray[np.float32]:
    side = len(texture)
    rough = rng.normal(0, amount, (2, 7, 7))
    # Splines are separable: a small matrix a side does what enlarging the field as a whole does.
    spline = zoom(np.eye(7), (side / 7, 1), order=3, mode="nearest", grid_mode=True)
    smooth = spline @ rough @ spline.T
    where = np.indices((side, side)) + smooth
    moved = [map_coordinates(texture[..., c], where, order=1, mode="nearest") for c in range(texture.shape[2])]
    return np.stack(moved, axis=2)
