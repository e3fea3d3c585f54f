"""What is measured: error and bytes of one way to store all maps of a character on all its tiles."""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import log10
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.codecs import Codec
from facezip.character.maps import Key
from facezip.character.scans import NEUTRAL, Character
from facezip.files.images import to_float
from facezip.fit.choice import whole_error
from facezip.fit.coded import coded_afterwards, fit_coded
from facezip.fit.methods import compress
from facezip.fit.storage import Storage
from facezip.pack.errors import Errors, model_errors, texture_errors
from facezip.pack.footprint import Texture
from facezip.pack.model import CompressedTextures


@dataclass(frozen=True)
class Point:
    """One measurement.

    Attributes
    ----------
    family : a key of :data:`reports.rates.families.FAMILIES`.
    codec : of the textures, as ``"astc_8x8"``.
    bytes : of GPU memory, all maps and tiles, the neutral included.
    bytes_on_wire : of the same textures as files: KTX2 under Zstandard, PNG where they are raw.
    bytes_per_texel : of GPU memory, over the texels of one expression, of all maps and tiles.
    bits : of GPU memory, a texel and channel of all expressions.
    fetches : textures that a shader reads for a pixel.
    rmse : 0..255, of what the GPU's decoder gives back, over all maps (:func:`facezip.fit.choice.whole_error`).
    psnr : the same in dB; null where nothing is lost.
    errors : by map, means over expressions.
    seconds : of fitting and coding; of coding alone where the fit is that of the point before.
    differences, weight_scale, weights : of a pack, ``weights`` the codec of its weight maps; null of textures.
    """

    family: str
    codec: str
    bytes: int
    bytes_on_wire: int
    bytes_per_texel: float
    bits: float
    fetches: int
    rmse: float
    psnr: float | None
    errors: Errors
    seconds: float
    differences: int | None
    weight_scale: int | None
    weights: str | None


@dataclass(frozen=True)
class Textures:
    """The rival: neutral and every expression of every map, each texture coded alone."""

    family: str
    codec: Codec

    def measure(self, character: Character) -> Point:
        """Code and decode all textures."""
        storage, begin = Storage(self.codec), perf_counter()
        kinds = {kind.name: kind for kind in character.maps}

        def coded(name: str, key: Key) -> NDArray[np.float32]:
            return storage.neutral(to_float(character.texels(name, key)), kinds[key[0]], (*key, name))

        errors = texture_errors(character, coded)
        for key in character.stacks:
            coded(NEUTRAL, key)
        seconds = perf_counter() - begin
        count = 1 + len(character.expressions)
        size = count * sum(storage.texture_bytes(Texture(*stack.neutral.shape)) for stack in character.stacks.values())
        return _point(character, self.family, storage, size, errors, count * len(kinds), seconds)


@dataclass(frozen=True)
class Pack:
    """A pack of one method, stored by codecs: with them in the loop of the fit, or after it."""

    family: str
    method: str
    differences: int
    weight_scale: int
    storage: Storage
    in_the_loop: bool = False

    def measure(self, character: Character) -> Point:
        """Fit, code and decode."""
        begin, storage = perf_counter(), replace(self.storage, files={})
        if self.in_the_loop:
            model = fit_coded(character, self.differences, self.weight_scale, storage)
        else:
            model = coded_afterwards(_fitted(character, self.method, self.differences, self.weight_scale), storage)
        seconds, cost = perf_counter() - begin, model.footprint
        errors = model_errors(character, model)
        return replace(
            _point(character, self.family, storage, storage.bytes_of(model), errors, cost.fetches, seconds),
            differences=cost.differences,
            weight_scale=self.weight_scale,
            weights=storage.weights.name,
        )


@lru_cache(maxsize=1)
def _fitted(character: Character, method: str, differences: int, weight_scale: int) -> CompressedTextures:
    """One fit for all the codecs that are tried after it."""
    return compress(character, method, differences=differences, weight_scale=weight_scale)


def _point(
    character: Character, family: str, storage: Storage, size: int, errors: Errors, fetches: int, seconds: float
) -> Point:
    """The measurement of textures of ``size`` bytes without weight maps."""
    stacks, rmse = character.stacks.values(), whole_error(errors, {})
    return Point(
        family=family,
        codec=storage.textures.name,
        bytes=size,
        bytes_on_wire=storage.bytes_on_wire,
        bytes_per_texel=size / sum(stack.resolution[0] * stack.resolution[1] for stack in stacks),
        bits=8 * size / sum(stack.textures.size for stack in stacks),
        fetches=fetches,
        rmse=rmse,
        psnr=20 * log10(255 / rmse) if rmse else None,
        errors={name: found.means for name, found in errors.items()},
        seconds=seconds,
        differences=None,
        weight_scale=None,
        weights=None,
    )
