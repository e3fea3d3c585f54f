"""How the maps of a pack lie in GPU memory: what they cost there and on the way there, and what a sampler sees."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.codecs import Codec, raw
from facezip.blocks.supercompression import supercompress
from facezip.character.maps import Map
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.files.images import Texels, png, to_float
from facezip.pack.footprint import Texture
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import STEPS, ZERO

RGBA = raw(4)
# What a texture is: its map or "weights", its tile, and which of those it is.
Place = tuple[str, int, str | int]


@dataclass(frozen=True)
class Storage:
    """The codecs of a pack's maps.

    Attributes
    ----------
    textures : of neutral and differences. One block size for both: the differences then make up best for what the
        neutral lost.
    weights : of weight maps, as many slots in one image as it has channels: one in BC4, four in RGBA of ASTC or BC7, or
        uncompressed.
    files : what was stored last in each place: blocks ``(bytes,)``, or texels ``(H, W, C)`` that are raw.
    """

    textures: Codec
    weights: Codec = RGBA
    files: dict[Place, NDArray[np.uint8]] = field(default_factory=dict, compare=False, repr=False)

    def bytes_of(self, model: CompressedTextures) -> int:
        """Bytes of all maps; uniform weights are shader constants and take none."""
        cost = model.footprint
        textures = sum((1 + cost.differences) * self.texture_bytes(texture) for tile in cost.tiles for texture in tile)
        if cost.layers == 0:
            return textures
        images = cost.expressions * len(self.groups(cost.differences))
        return textures + images * sum(self.weights.bytes_of(height, width) for height, width in cost.weight_sizes)

    @property
    def bytes_on_wire(self) -> int:
        """Bytes of :attr:`files` as they are sent: blocks under Zstandard as in KTX2, raw texels as PNGs."""
        return sum(len(png(one) if one.ndim == 3 else supercompress(one)) for one in self.files.values())

    def groups(self, slots: int) -> list[slice]:
        """The slots that share an image of weight maps."""
        size = self.weights.channels
        return [slice(first, min(first + size, slots)) for first in range(0, slots, size)]

    def texture_bytes(self, texture: Texture) -> int:
        """Bytes of one texture: of its blocks, or of the channels that it has where there are none."""
        plain = self.textures.encode is None
        return texture.plain if plain else self.textures.bytes_of(texture.height, texture.width)

    def neutral(self, texels: NDArray[np.float32], kind: Map, place: Place) -> NDArray[np.float32]:
        """What is left of a neutral's texels ``(H, W, C)`` in [0, 1]."""
        image: NDArray[Any] = packed_neutral(texels, kind, 8)
        if kind.is_normal:
            # A sampler rebuilds it from x and y: no bits should go there.
            image[..., 2] = ZERO
        return to_float(unpacked_neutral(self._seen(self.textures, [image], place)[0], kind))

    def difference(
        self, texture: NDArray[np.float32], importance: NDArray[np.float32], place: Place
    ) -> NDArray[np.float32]:
        """What is left of a difference texture ``(H, W, C)``; one range a channel, that of texels that count."""
        largest = np.abs(texture[importance > 0]).max(axis=0)
        step = np.maximum(largest, np.float32(1e-12)) / np.float32(STEPS)
        bytes_ = (np.clip(np.rint(texture / step), -STEPS, STEPS) + ZERO).astype(np.uint8)
        channels = texture.shape[2]
        # Images have one channel or three.
        image = np.pad(bytes_, ((0, 0), (0, 0), (0, int(channels == 2))), constant_values=ZERO)
        stored = self._seen(self.textures, [image], place)[0][..., :channels]
        values: NDArray[np.float32] = (stored.astype(np.float32) - ZERO) * step
        return values

    def coded_weights(self, maps: NDArray[np.float32], place: Place) -> NDArray[np.float32]:
        """What is left of the weight maps ``(h, N, R, w)`` of one group; one range a slot for all expressions.

        Uniform weights are no textures, and stay as they are.
        """
        if maps.shape[::3] == (1, 1):
            return maps
        low = maps.min(axis=(0, 1, 3), keepdims=True)
        range_ = np.maximum(maps.max(axis=(0, 1, 3), keepdims=True) - low, np.float32(1e-12))
        images = np.rint((maps - low) / range_ * np.float32(255)).astype(np.uint8).transpose(1, 0, 3, 2)
        stored = np.stack([to_float(image) for image in self._seen(self.weights, images, place)])
        values: NDArray[np.float32] = stored.transpose(1, 0, 3, 2) * range_ + low
        return values

    def _seen(self, codec: Codec, images: Sequence[NDArray[np.uint8]], place: Place) -> list[Texels]:
        """What a sampler sees of the layers of one file."""
        stored = [codec.store(image) for image in images]
        self.files[place] = np.concatenate(stored if codec.encode else images)
        return [codec.load(one, image.shape) for one, image in zip(stored, images, strict=True)]
