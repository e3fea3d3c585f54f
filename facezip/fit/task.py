"""What every method of compression is given, and what it gives."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.neutrals import as_packed
from facezip.character.samples import BESIDE_THE_FACE, Samples
from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float
from facezip.fit.given import GivenMasks
from facezip.fit.importance import weighted_samples
from facezip.fit.kept import KeptRegion
from facezip.fit.locks import Lock
from facezip.fit.painted import Painted
from facezip.fit.settings import Settings
from facezip.pack.model import Part


@dataclass(frozen=True, eq=False)
class Task:
    """What a method is given: ``factors`` are those of each map's squared error."""

    character: Character
    settings: Settings
    factors: Mapping[str, float]
    importance: Mapping[Key, NDArray[np.float32]]
    given_masks: GivenMasks | None
    locks: tuple[Lock, ...] = ()
    painted: tuple[Painted, ...] = ()
    kept: KeptRegion | None = None

    def check(self, method: str) -> None:
        """Raise for what is asked of a method that cannot do it, or of an expression or a tile that there is not."""
        sparse = self.settings.sparse is not None
        refusals = {
            f"given masks: method {method} takes none; use masks": self.given_masks and method != "masks",
            f"locks: method {method} takes none; use refined": self.locks and method != "refined",
            f"painted weight maps: method {method} takes none; use refined": self.painted and method != "refined",
            "painted weight maps: they say which layers an expression uses; leave sparse out": self.painted and sparse,
            f"a region to keep: method {method} keeps none; use refined": self.kept and method != "refined",
            "a region to keep: all layers and weights stay in it; leave sparse, locks and painted weight maps out": (
                self.kept and (sparse or self.locks or self.painted)
            ),
        }
        for reason in (reason for reason, holds in refusals.items() if holds):
            raise FaceZipError(ErrorCode.BAD_VALUE, reason)
        for one in self.painted:
            self.character.index(one.expression)
            self.character.tile(one.tile)

    @property
    def slots(self) -> int:
        """Difference textures: no more than there are expressions."""
        return min(self.settings.differences, len(self.character.expressions))

    @property
    def sparse(self) -> int | None:
        """How many of the slots an expression may use, where that is fewer than all."""
        sparse = self.settings.sparse
        return sparse if sparse is not None and sparse < self.slots else None

    @property
    def beside_packed(self) -> dict[Key, Samples]:
        """The texels of all maps beside their neutrals as a pack stores them, those off the face counting a little."""
        character = self.character
        return {key: self.samples(key, _as_packed(character, key), BESIDE_THE_FACE) for key in character.stacks}

    def samples(self, key: Key, stack: Stack, beside: float = 0) -> Samples:
        """The texels of a map on a tile, weighted."""
        albedos = self.importance.get((self.character.maps[0].name, key[1]))
        return weighted_samples(stack, self.factors[key[0]], self.importance.get(key, albedos), beside)

    def part(self, key: Key, differences: NDArray[np.float32], ranges: NDArray[np.float32] | None = None) -> Part:
        """Difference textures with the neutral that they belong to."""
        neutral = to_float(self.character.stacks[key].neutral)
        return Part(neutral, differences, self.character.neutral_bits[key], ranges)


class Fit(NamedTuple):
    """Attributes as of :class:`facezip.pack.model.CompressedTextures`."""

    parts: dict[Key, Part]
    weights: Mapping[int, NDArray[np.float32]]
    weight_ranges: Mapping[int, NDArray[np.float32]] = {}


def _as_packed(character: Character, key: Key) -> Stack:
    """The scans beside their neutral as a pack stores it: difference textures make up for what that loses."""
    stack = character.stacks[key]
    return replace(stack, neutral=as_packed(stack.neutral, character.kind(key[0]), character.neutral_bits[key]))
