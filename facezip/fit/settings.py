"""What a method may be told, and what of it each method takes notice of."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.pack.checks import MAX_DIFFERENCES
from facezip.pack.footprint import WEIGHT_SCALES
from facezip.pack.manifest import MadeWith

PAPER_DIFFERENCES = 4
# How long to fit, from the fewest alternations to the most.
EFFORTS = ("fast", "default", "best")


@dataclass(frozen=True)
class Settings:
    """What a method may be told.

    Attributes
    ----------
    differences : number R of difference textures, 1 to 8.
    weight_scale : how many times smaller weight maps are than the first map's textures: 4, 8, 16 or 32.
    masks : number of masks on the face region (paper, masks).
    restarts : random starts of the stitching (paper; not its variants).
    seed : of every random choice.
    nonnegative : whether weights are positive or zero, at most 1, so that differences are only ever added (refined,
        masks).
    sparse : how many difference textures an expression may use, at least 1; all where None (refined).
    effort : how long to fit, one of :data:`EFFORTS` (refined).
    """

    differences: int = 4
    weight_scale: int = 8
    masks: int = 53
    restarts: int = 100
    seed: int = 0
    nonnegative: bool = False
    sparse: int | None = None
    effort: str = "default"

    def check(self, method: str) -> None:
        """Raise ``BAD_VALUE`` for a method that there is not, or a setting outside its range."""
        if method not in USED:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"method '{method}': must be one of {', '.join(USED)}")
        ranges = {
            "differences": (1, MAX_DIFFERENCES),
            "masks": (1, 100_000),
            "restarts": (1, 1_000_000),
            "seed": (0, 2**32 - 1),
        }
        for name, (low, high) in ranges.items():
            if not low <= getattr(self, name) <= high:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"{name} {getattr(self, name)}: must lie in {low}..{high}")
        if self.weight_scale not in WEIGHT_SCALES:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight scale {self.weight_scale}: must be one of {WEIGHT_SCALES}")
        if self.nonnegative and "nonnegative" not in USED[method]:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"nonnegative: method {method} cannot; use refined or masks")
        if self.sparse is not None and "sparse" not in USED[method]:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"sparse: method {method} cannot; use refined")
        if self.sparse is not None and not 1 <= self.sparse <= self.differences:
            reason = f"must lie in 1..{self.differences}, the number of difference textures"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"sparse {self.sparse}: {reason}")
        if self.effort not in EFFORTS:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"effort '{self.effort}': must be one of {', '.join(EFFORTS)}")
        if self.effort != Settings.effort and "effort" not in USED[method]:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"effort {self.effort}: method {method} has one alone; use refined")
        if method.startswith("paper") and self.differences != PAPER_DIFFERENCES:
            raise FaceZipError(
                ErrorCode.BAD_VALUE,
                f"differences {self.differences}: the paper's method makes exactly {PAPER_DIFFERENCES} textures",
            )


_OF_THE_PAPER = ("differences", "weight_scale", "masks", "seed")
# By method, the settings that it uses.
USED: dict[str, tuple[str, ...]] = {
    "refined": ("differences", "weight_scale", "nonnegative", "sparse", "effort"),
    "paper": (*_OF_THE_PAPER, "restarts"),
    "paper-optimised": _OF_THE_PAPER,
    "paper-unpermuted": _OF_THE_PAPER,
    "pca": ("differences",),
    "masks": ("differences", "weight_scale", "masks", "seed", "nonnegative"),
}


def made_with(method: str, settings: Mapping[str, Any]) -> MadeWith:
    """The method, and those of the settings that it uses, but for what is off or as ever: what a pack states of its
    making.
    """
    used = {
        name: value
        for name, value in settings.items()
        if name in USED[method] and value is not False and value not in (None, Settings.effort)
    }
    return {"method": method, **used}
