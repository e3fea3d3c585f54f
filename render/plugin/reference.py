"""What a render is compared with: the mean of independent renders, its standard error, and how statistics spread."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.writing import write_whole
from render.exr import read_conditions, read_exr, write_exr
from render.plugin.statistics import STATISTICS, Ratios, Spread, leave_one_out, noise_ratios, probability, rounding_of

FORMAT = "facezip-reference/1"
# Fewer renders say too little of their own noise.
FEWEST_RENDERS = 8
# A comparison that is less probable is looked at again, without each of its renders.
UNLIKELY = 0.01
# The part of a reference that says which pixels do not count.
_IGNORED = "ignored"
_LARGEST_HALF = np.float32(65504)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A test against a reference.

    Attributes
    ----------
    probability : that noise alone gives so large a difference, in [0, 1], corrected for pixels and statistics.
    statistic : the one that is least likely: ``largest`` or ``sum``, and the side of its blocks in pixels.
    image : ``(H, W, C)`` float32, mean of the test's renders.
    ratios : differences over their standard errors, by the side of the blocks.
    """

    probability: float
    statistic: str
    image: NDArray[np.float32]
    ratios: dict[int, Ratios]

    @property
    def scale(self) -> int:
        """Side in pixels of the blocks that tell most."""
        return int(self.statistic.rpartition("_")[2])


@dataclass(frozen=True, eq=False)
class Reference:
    """A stored expectation.

    Attributes
    ----------
    mean, error : ``(H, W, C)`` float32, of half precision: mean of the renders, and its standard error.
    renders : how many.
    spreads : how every statistic came out for each of the renders against the others.
    ignored : ``(H, W)``, pixels that did not count in them, or None.
    """

    mean: NDArray[np.float32]
    error: NDArray[np.float32]
    renders: int
    spreads: dict[str, Spread]
    ignored: NDArray[np.bool_] | None = None

    @staticmethod
    def of(renders: NDArray[np.float32], ignored: NDArray[np.bool_] | None = None) -> "Reference":
        """The reference of ``(N, H, W, C)`` independent renders, C 3 or 4, ``ignored`` of its pixels ``(H, W)``.

        Raises
        ------
        FaceZipError
            ``BAD_VALUE``: fewer than :data:`FEWEST_RENDERS`.
        """
        count = len(renders)
        if count < FEWEST_RENDERS:
            reason = f"a reference needs at least {FEWEST_RENDERS} independent renders to know their noise, not {count}"
            raise FaceZipError(
                ErrorCode.BAD_VALUE,
                f"{reason}; pass a function of the seed, more renders, or [image] * {FEWEST_RENDERS} without noise",
            )
        renders = np.clip(renders, -_LARGEST_HALF, _LARGEST_HALF)
        mean = renders.mean(axis=0, dtype=np.float64)
        error = renders.std(axis=0, ddof=1, dtype=np.float64) / np.sqrt(count)
        return Reference(_stored(mean), _stored(error), count, leave_one_out(renders, ignored), ignored)

    def compare(self, renders: NDArray[np.float32], ignored: NDArray[np.bool_] | None = None) -> Comparison:
        """Compare the mean of ``(n, H, W, C)`` independent renders, n ≥ 1, none of which is part of the reference.

        What looks like a difference has to be one without any single render too: an event that is too rare for the
        reference to know shows in one alone. Where more pixels are ``ignored`` than when the reference was made, only
        the largest ratios count: how sums spread over what is left is not known.

        Raises
        ------
        FaceZipError
            ``BAD_VALUE``: the reference ignores pixels that the test does not.
        """
        spreads = self._spreads(ignored)
        clipped = np.clip(renders, -_LARGEST_HALF, _LARGEST_HALF).astype(np.float64)
        found = self._judge(clipped, spreads, ignored)
        if len(clipped) > 2 and found.probability < UNLIKELY:
            others = (self._judge(np.delete(clipped, k, axis=0), spreads, ignored) for k in range(len(clipped)))
            likelier = max(others, key=lambda one: one.probability)
            found = likelier if likelier.probability >= UNLIKELY else found
        return replace(found, image=clipped.mean(axis=0).astype(np.float32))

    def _spreads(self, ignored: NDArray[np.bool_] | None) -> dict[str, Spread]:
        """Those that hold without the ignored pixels."""
        own, given = (np.zeros(self.mean.shape[:2], bool) if mask is None else mask for mask in (self.ignored, ignored))
        if (own & ~given).any():
            count = np.count_nonzero(own & ~given)
            reason = f"its reference was made without {count} pixels that the test does not ignore"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{reason}; generate it again")
        same = bool((own == given).all())
        return {name: spread for name, spread in self.spreads.items() if same or name.startswith("largest")}

    def _judge(
        self, renders: NDArray[np.float64], spreads: dict[str, Spread], ignored: NDArray[np.bool_] | None
    ) -> Comparison:
        mean = self.mean.astype(np.float64)
        # No smaller than what may have been rounded to it.
        error = self.error + rounding_of(self.error)
        variance = np.square(error) * self.renders
        ratios = noise_ratios(renders, mean, variance, self.renders, rounding_of(mean), ignored)
        return Comparison(*probability(ratios, spreads), renders.mean(axis=0).astype(np.float32), ratios)

    def write(self, path: Path, conditions: Mapping[str, str]) -> None:
        """Write :meth:`content`, whole or not at all; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
        write_whole(path, self.content(conditions))

    def content(self, conditions: Mapping[str, str]) -> bytes:
        """A multi-part OpenEXR file, with conditions as its attributes."""
        spreads = json.dumps({name: asdict(spread) for name, spread in self.spreads.items()})
        header = {**conditions, "facezip": FORMAT, "renders": str(self.renders), "spreads": spreads}
        parts = {"mean": self.mean, "error": self.error}
        if self.ignored is not None:
            parts[_IGNORED] = np.repeat(self.ignored[..., None], 3, axis=2).astype(np.float32)
        with TemporaryDirectory() as place:
            write_exr(Path(place) / "reference.exr", parts, header)
            return (Path(place) / "reference.exr").read_bytes()

    @staticmethod
    def read(path: Path) -> "Reference":
        """Read the file of :meth:`content`.

        Raises
        ------
        FaceZipError
            ``MISSING_FILE``, or ``UNREADABLE_IMAGE`` for a file that is damaged or something else.
        """
        parts, header = read_exr(path), read_conditions(path)
        try:
            if header["facezip"] != FORMAT:
                raise ValueError(header["facezip"])
            stored = json.loads(header["spreads"])
            spreads = {name: Spread(**stored[name]) for name in STATISTICS}
            ignored = parts[_IGNORED][..., 0] > 0.5 if _IGNORED in parts else None
            return Reference(parts["mean"], parts["error"], int(header["renders"]), spreads, ignored)
        except (KeyError, TypeError, ValueError):
            reason = f"not a reference of format {FORMAT}; generate it again"
            raise FaceZipError(ErrorCode.UNREADABLE_IMAGE, f"{path}: {reason}") from None


def _stored(image: NDArray[np.float64]) -> NDArray[np.float32]:
    return image.astype(np.float16).astype(np.float32)
