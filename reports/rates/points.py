"""What is measured: error and bytes of one way to store a character's textures."""

from dataclasses import dataclass
from functools import partial
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.codecs import Codec
from facezip.character.maps import ALBEDO, Key
from facezip.character.scans import Character
from facezip.files.images import to_float
from facezip.fit.coded import coded_afterwards, fit_coded
from facezip.fit.methods import compress
from facezip.fit.storage import Storage
from facezip.pack.errors import model_errors, texture_errors


@dataclass(frozen=True)
class Point:
    """One measurement.

    Attributes
    ----------
    family : a key of :data:`reports.rates.families.FAMILIES`.
    codec : of the textures, as ``"astc_8x8"``.
    bytes_per_texel : bytes of GPU memory over the texels of one texture, neutral included.
    fetches : textures that a shader reads for a pixel.
    rmse : 0..255, mean over expressions, of what the GPU's decoder gives back.
    seconds : of fitting and coding.
    differences, weight_scale : of a pack.
    """

    family: str
    codec: str
    bytes_per_texel: float
    fetches: int
    rmse: float
    seconds: float
    differences: int | None = None
    weight_scale: int | None = None


@dataclass(frozen=True)
class Textures:
    """The rival: neutral and every expression, each coded alone."""

    family: str
    codec: Codec

    def measure(self, character: Character) -> Point:
        """Code and decode all textures."""
        begin = perf_counter()
        errors = texture_errors(character, partial(_round_trip, character, self.codec))
        count, (height, width) = 1 + len(character.expressions), character.first.resolution
        size = count * self.codec.bytes_of(height, width) / (height * width)
        return Point(self.family, self.codec.name, size, count, errors[ALBEDO]["rmse"], perf_counter() - begin)


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
        begin = perf_counter()
        if self.in_the_loop:
            model = fit_coded(character, self.differences, self.weight_scale, self.storage)
        else:
            fit = compress(character, self.method, differences=self.differences, weight_scale=self.weight_scale)
            model = coded_afterwards(fit, self.storage)
        seconds = perf_counter() - begin
        height, width = character.first.resolution
        return Point(
            self.family,
            self.storage.textures.name,
            self.storage.bytes_of(model) / (height * width),
            model.footprint.fetches,
            model_errors(character, model)[ALBEDO]["rmse"],
            seconds,
            model.footprint.differences,
            self.weight_scale,
        )


def _round_trip(character: Character, codec: Codec, name: str, key: Key) -> NDArray[np.float32]:
    texels = np.rint(to_float(character.texels(name, key)) * 255).astype(np.uint8)
    return codec.round_trip(texels).astype(np.float32) / np.float32(255)
