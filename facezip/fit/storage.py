"""How the maps of a pack lie in GPU memory: what they cost there, and what a sampler sees of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.blocks import bc4
from facezip.blocks.codecs import Codec
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import STEPS, ZERO, rounded_weights


@dataclass(frozen=True)
class Storage:
    """The codecs of a pack's maps.

    Attributes
    ----------
    textures : of neutral and differences. One block size for both: the differences then make up best for what the
        neutral lost.
    weights_in_bc4 : whether weight maps are BC4, one a slot; otherwise 8 bits a channel, four slots an RGBA layer.
    """

    textures: Codec
    weights_in_bc4: bool = False

    def bytes_of(self, model: CompressedTextures) -> int:
        """Bytes of all maps; uniform weights are shader constants and take none."""
        slots, height, width, _ = model.differences.shape
        count, low_height, low_width, _ = model.weights.shape
        textures = (1 + slots) * self.textures.bytes_of(height, width)
        if (low_height, low_width) == (1, 1):
            return textures
        if self.weights_in_bc4:
            return textures + count * slots * bc4.bytes_of(low_height, low_width)
        layers = -(-slots // SLOTS_PER_LAYER)
        return textures + count * low_height * low_width * SLOTS_PER_LAYER * layers

    def neutral(self, texture: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is left of a neutral ``(H, W, C)`` in [0, 1]."""
        stored = self.textures.round_trip(np.rint(texture * 255).astype(np.uint8))
        return stored.astype(np.float32) / np.float32(255)

    def difference(self, texture: NDArray[np.float32], importance: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is left of a difference texture ``(H, W, C)``; one range a channel, that of texels that count."""
        largest = np.abs(texture[importance > 0]).max(axis=0)
        step = np.maximum(largest, np.float32(1e-12)) / np.float32(STEPS)
        stored = self.textures.round_trip((np.clip(np.rint(texture / step), -STEPS, STEPS) + ZERO).astype(np.uint8))
        values: NDArray[np.float32] = (stored.astype(np.float32) - ZERO) * step
        return values

    def weights(self, maps: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is left of one slot's weight maps ``(h, N, w)``; one range for all."""
        if not self.weights_in_bc4 or maps.shape[::2] == (1, 1):
            return rounded_weights(maps.swapaxes(0, 1)[..., None])[..., 0].swapaxes(0, 1)
        low, range_ = maps.min(), np.maximum(np.ptp(maps), np.float32(1e-12))
        return bc4.round_trip((maps.swapaxes(0, 1) - low) / range_).swapaxes(0, 1) * range_ + low
