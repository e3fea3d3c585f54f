"""How many difference textures, how fine the weights: the cheapest that meets a target, or the best within a budget."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians, sqrt

from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.importance import Importance
from facezip.fit.methods import compress
from facezip.machine.progress import task
from facezip.pack.checks import MAX_DIFFERENCES
from facezip.pack.errors import Errors, MapErrors, model_errors
from facezip.pack.footprint import WEIGHT_SCALES, Footprint, Texture
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import quantise

# Difference textures, and how many times smaller weight maps are.
Settings = tuple[int, int]


@dataclass(frozen=True)
class Trial:
    """One fit that was tried.

    Attributes
    ----------
    differences, weight_scale : its settings.
    bytes_on_gpu : what they cost at run time.
    rmse : 0..255, of the 8-bit pack inside the mask, over all maps (:func:`whole_error`).
    """

    differences: int
    weight_scale: int
    bytes_on_gpu: int
    rmse: float


@dataclass(frozen=True, eq=False)
class Choice:
    """What was chosen, and why.

    Attributes
    ----------
    model : the chosen fit.
    trial : its settings, cost and error.
    tried : all fits in the order in which they were made.
    reason : one sentence for people.
    """

    model: CompressedTextures
    trial: Trial
    tried: tuple[Trial, ...]
    reason: str


def choose(
    character: Character,
    *,
    target_rmse: float | None = None,
    budget_bytes: float | None = None,
    importance: Importance | None = None,
    map_weights: Mapping[str, float] | None = None,
) -> Choice:
    """The refined fit that meets a target most cheaply, or that has the least error within a budget.

    Error falls with every further texture and with every finer weight map, so that few of the combinations have to be
    fitted: from the finest weights on, a fit that misses the target asks for another texture, one that meets it for
    coarser weights.

    Parameters
    ----------
    character : what to compress.
    target_rmse : largest error over all maps, 0..255, or None.
    budget_bytes : most bytes on the GPU at 8 bits a channel, or None. One of the two must be given; with both, the
        cheapest that meets the target has to be within the budget.
    importance, map_weights : as in :func:`facezip.compress`.

    Raises
    ------
    FaceZipError
        ``OUT_OF_REACH``: no combination meets the target, or none is within the budget; the message names the best
        there is. ``BAD_VALUE``: neither is given, or one is not positive.
    """
    limits = {"target RMSE": target_rmse, "budget": budget_bytes}
    if target_rmse is None and budget_bytes is None:
        raise FaceZipError(ErrorCode.BAD_VALUE, "neither a target nor a budget to choose by: give one of them, or both")
    for words, limit in limits.items():
        if limit is not None and not limit > 0:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{words} {limit:g}: must be a positive number")
    budget = float("inf") if budget_bytes is None else budget_bytes
    search = _Search(character, importance, map_weights or {})
    settings = search.within(budget)
    if not settings:
        least = min(search.within(float("inf")), key=search.cost)
        raise FaceZipError(
            ErrorCode.OUT_OF_REACH,
            f"budget of {budget / 1e6:g} MB: the least is {_megabytes(search.cost(least))} ({_words(*least)}); "
            "raise the budget or use smaller textures",
        )
    if target_rmse is None:
        trial, model = search.best_of(settings)
        reason = f"the least error within {budget / 1e6:g} MB"
    else:
        trial, model = search.cheapest(settings, target_rmse)
        reason = f"the least memory with an error of at most {target_rmse:g}"
    words = _words(trial.differences, trial.weight_scale)
    of = f", of {len(search.tried)} fits" if len(search.tried) > 1 else ""
    return Choice(model, trial, tuple(search.tried), f"{words}: {reason}{of}")


class _Search:
    """Fits of one character with (differences, weight scale)."""

    def __init__(self, character: Character, importance: Importance | None, map_weights: Mapping[str, float]) -> None:
        self._character, self._importance, self._map_weights = character, importance, map_weights
        self.tried: list[Trial] = []

    def within(self, budget: float) -> list[Settings]:
        """All settings that cost at most ``budget`` bytes."""
        most = min(MAX_DIFFERENCES, len(self._character.expressions))
        every = [(differences, scale) for differences in range(1, most + 1) for scale in WEIGHT_SCALES]
        return [settings for settings in every if self.cost(settings) <= budget]

    def cost(self, settings: Settings) -> int:
        """Bytes on the GPU."""
        differences, scale = settings
        stacks, tiles = self._character.stacks, self._character.tiles
        names = [kind.name for kind in self._character.maps]
        textures = tuple(tuple(Texture(*stacks[name, tile].neutral.shape) for name in names) for tile in tiles)
        low = tuple((-(-tile[0].height // scale), -(-tile[0].width // scale)) for tile in textures)
        return Footprint(textures, low, differences, len(self._character.expressions)).bytes_on_gpu

    def best_of(self, settings: list[Settings]) -> tuple[Trial, CompressedTextures]:
        """The least error. Only settings are tried that no other beats in both textures and weights."""
        worth = [(r, s) for r, s in settings if not any((q, t) != (r, s) and q >= r and t <= s for q, t in settings)]
        with task("Choosing", len(worth)) as advance:
            best: tuple[Trial, CompressedTextures] | None = None
            for candidate in worth:
                fitted = self._fit(candidate)
                if best is None or fitted[0].rmse < best[0].rmse:
                    best = fitted
                # Not held while the next one is made.
                del fitted
                advance()
        if best is None:
            raise ValueError("no settings to choose from")
        return best

    def cheapest(self, settings: list[Settings], target: float) -> tuple[Trial, CompressedTextures]:
        """The least memory that meets the target: a walk along the border between what misses it and what meets it."""
        scales = sorted({scale for _, scale in settings})
        most = max(differences for differences, _ in settings)
        best: tuple[Trial, CompressedTextures] | None = None
        differences, finest = 1, 0
        with task("Choosing", most + len(scales)) as advance:
            while differences <= most and finest < len(scales):
                candidate = differences, scales[finest]
                if candidate not in settings or (best and self.cost(candidate) >= best[0].bytes_on_gpu):
                    # Too dear: with coarser weights it may not be.
                    finest += 1
                else:
                    fitted = self._fit(candidate)
                    if fitted[0].rmse <= target:
                        best, finest = fitted, finest + 1
                    else:
                        differences += 1
                    del fitted
                advance()
        if best is None:
            nearest = min(self.tried, key=lambda trial: trial.rmse)
            raise FaceZipError(
                ErrorCode.OUT_OF_REACH,
                f"target RMSE {target:g}: the best within reach is {nearest.rmse:.3f} with "
                f"{_words(nearest.differences, nearest.weight_scale)}, {_megabytes(nearest.bytes_on_gpu)}; raise the "
                "target or the budget",
            )
        return best

    def _fit(self, settings: Settings) -> tuple[Trial, CompressedTextures]:
        """Fit, and measure what a pack would hold."""
        differences, scale = settings
        model = compress(
            self._character,
            differences=differences,
            weight_scale=scale,
            importance=self._importance,
            map_weights=self._map_weights,
        )
        rmse = whole_error(model_errors(self._character, quantise(model)), self._map_weights)
        self.tried.append(Trial(differences, scale, self.cost(settings), rmse))
        return self.tried[-1], model


def whole_error(errors: Errors, map_weights: Mapping[str, float]) -> float:
    """One number for all maps, 0..255: the root of the weighted mean of their squared errors, that of an albedo alone.

    Normals count as the 8-bit images (n + 1) / 2 that they would be: an angle of θ radians is θ · 255 / (2 √3).
    """
    squares = {name: _in_bytes(found) ** 2 for name, found in errors.items()}
    weights = {name: map_weights.get(name, 1.0) for name in squares}
    return sqrt(sum(weights[name] * square for name, square in squares.items()) / sum(weights.values()))


def _in_bytes(found: MapErrors) -> float:
    angle = found.angular_error_rms
    return found.mean if angle is None else radians(angle) * 255 / (2 * sqrt(3))


def _megabytes(count: int) -> str:
    """With two decimals; with three digits where those would say little of it."""
    return f"{count / 1e6:{'.2f' if count >= 1e6 else '.3g'}} MB"


def _words(differences: int, weight_scale: int) -> str:
    return f"{differences} difference texture{'s' * (differences > 1)} and weights at 1/{weight_scale}"
