"""The pictures of a page of layers: textures, weight maps, and what a layer adds to an expression."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Map
from facezip.character.tiles import Atlas
from facezip.pack.masked import STEP
from facezip.pack.model import CompressedTextures
from reports.images import data_uri, to_bytes
from reports.layers.head import Sight
from reports.layers.measure import upsampled

# A side of a texture, of the large pictures of the head and of its small ones.
TEXTURE, LARGE, SMALL = 512, 420, 144
QUALITY = 88
# Colours of -1, 0 and 1: grey where a weight is zero, blue below, amber above.
SIGNED = np.array([[0.25, 0.66, 1.0], [0.23, 0.235, 0.25], [1.0, 0.69, 0.2]], np.float32)
# A few texels of the strongest weights would leave all others grey.
MOST_WEIGHTS = 99.5
# How many times what a layer adds is shown, so that pores are seen too.
AMPLIFIED = 4
# Beside the strongest tenth of a percent of a difference texture, all others could not be seen.
STRONGEST = 99.8


class Pictures:
    """Data URIs of the pictures of one pack."""

    def __init__(self, model: CompressedTextures) -> None:
        self._model = model
        self._atlas = Atlas.of(model.tiles)

    @cached_property
    def largest(self) -> NDArray[np.float32]:
        """``(R,)``: the weights of each layer at the ends of its colours, which few texels of all maps go beyond."""
        maps = self._model.weights.values()
        extents = [np.percentile(np.abs(each), MOST_WEIGHTS, axis=(0, 1, 2)) for each in maps]
        return np.maximum(np.max(extents, axis=0), 1e-12).astype(np.float32)

    def texture(self, kind: Map, layer: int) -> str:
        """A difference texture about grey, its strongest texels at the ends of the display's range."""

        def of_tile(tile: int) -> NDArray[np.float32]:
            return _three(self._thin(self._model.parts[kind.name, tile].differences[layer]))

        whole = self._joined(of_tile)
        strongest = max(float(np.percentile(np.abs(whole), STRONGEST)), 1e-6)
        return data_uri(to_bytes(np.float32(0.5) + whole / np.float32(2 * strongest)), QUALITY)

    def alone(self, expression: str, layer: int) -> str:
        """The neutral's albedo and one layer of an expression, on the expression's shape."""

        def of_tile(tile: int) -> NDArray[np.float32]:
            neutral = self._thin(self._model.parts[ALBEDO, tile].neutral)
            return np.clip(_three(neutral + self._added(expression, layer, tile)), 0, 1)

        return self._on_head(expression, LARGE, self._joined(of_tile))

    def added(self, expression: str, layer: int) -> str:
        """What a layer adds to an expression's albedo, :data:`AMPLIFIED` about grey."""

        def of_tile(tile: int) -> NDArray[np.float32]:
            part = _three(self._added(expression, layer, tile))
            return np.clip(np.float32(0.5) + np.float32(AMPLIFIED) * part, 0, 1)

        return self._on_head(expression, LARGE, self._joined(of_tile))

    def weights(self, expression: str, layer: int, side: int = SMALL) -> str:
        """A weight map on the expression's shape, by :data:`SIGNED`, the ends at the layer's largest weight."""
        n = self._model.expressions.index(expression)

        def of_tile(tile: int) -> NDArray[np.float32]:
            maps = self._model.weights[tile][n][..., layer : layer + 1]
            return upsampled(np.ascontiguousarray(maps), self._size(tile), self._step(tile))

        return self._on_head(expression, side, signed(self._joined(of_tile)[..., 0] / self.largest[layer]))

    def mask(self, k: int) -> str:
        """A mask, as light on the neutral."""
        masked, model = self._model.masked, self._model
        if masked is None:
            raise ValueError("weight maps are not made of masks")

        def of_tile(tile: int) -> NDArray[np.float32]:
            mask = STEP * masked.masks[tile][k][..., None].astype(np.float32)
            neutral = _three(self._thin(model.parts[ALBEDO, tile].neutral))
            amount = upsampled(mask, self._size(tile), self._step(tile))
            return neutral.mean(axis=2, keepdims=True) * np.float32(0.3) * (1 - amount) + _LIT * amount

        return self._on_head(None, SMALL, self._joined(of_tile))

    def _added(self, expression: str, layer: int, tile: int) -> NDArray[np.float32]:
        n, part = self._model.expressions.index(expression), self._model.parts[ALBEDO, tile]
        maps = np.ascontiguousarray(self._model.weights[tile][n][..., layer : layer + 1])
        return self._thin(part.differences[layer]) * upsampled(maps, self._size(tile), self._step(tile))

    def _on_head(self, expression: str | None, side: int, texture: NDArray[np.float32]) -> str:
        return data_uri(np.ascontiguousarray(self._sight(expression, side).picture(texture)), QUALITY)

    def _sight(self, expression: str | None, side: int) -> Sight:
        meshes = self._model.meshes
        if meshes is None:
            return Sight.of_chart(side)
        shape = meshes.neutral if expression is None else meshes.vertices[self._model.expressions.index(expression)]
        return Sight.of_head(meshes, shape, self._atlas, side)

    def _joined(self, of_tile: Callable[[int], NDArray[np.float32]]) -> NDArray[np.float32]:
        return self._atlas.joined({tile: of_tile(tile) for tile in self._model.tiles})

    def _size(self, tile: int) -> tuple[int, int]:
        height, width = self._model.parts[ALBEDO, tile].neutral.shape[:2]
        return height, width

    def _step(self, tile: int) -> int:
        return -(-max(self._size(tile)) // TEXTURE)

    def _thin(self, texture: NDArray[np.float32]) -> NDArray[np.float32]:
        step = -(-max(texture.shape[:2]) // TEXTURE)
        return texture[::step, ::step]


_LIT = np.array([1.0, 0.78, 0.42], np.float32)


def signed(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values of -1..1 ``(H, W)`` as colours ``(H, W, 3)`` in [0, 1], by :data:`SIGNED`."""
    stops = np.array([-1, 0, 1], np.float32)
    return np.stack([np.interp(values, stops, SIGNED[:, c]) for c in range(3)], axis=-1).astype(np.float32)


def signed_gradient() -> str:
    """The colours of :func:`signed` as those of a CSS gradient."""
    return ", ".join("#{:02x}{:02x}{:02x}".format(*colour) for colour in to_bytes(SIGNED))


def _three(texels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Texels of any number of channels as three that a picture shows."""
    channels = texels.shape[2]
    if channels == 2:
        return np.pad(texels, ((0, 0), (0, 0), (0, 1)))
    return np.repeat(texels, 3, axis=2) if channels == 1 else texels[..., :3]
