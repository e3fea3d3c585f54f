"""All levels of a pack's textures as they lie in an engine's memory, fitted to what a block codec keeps of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from facezip.codecs import Codec
from facezip.export.mips import WIDE, Pyramid
from facezip.export.source import Fill, Source, from_steps, to_steps
from facezip.model import CompressedTextures
from facezip.progress import track
from facezip.quantise import ZERO
from facezip.samples import Samples
from facezip.sweep import solve_texture
from facezip.textures import to_float


@dataclass
class Level:
    """One level of all maps, as stored and as a sampler sees it.

    Attributes
    ----------
    neutral, differences : ``(h, w, C)`` and ``(R, h, w, C)`` float32, encoded values.
    stored : the codec's bytes, of ``"neutral"``, ``"difference_0"`` ...
    loss : by the same names, the RMSE that storing added to a map, in units of its 0..255 texels inside the chart.
    """

    neutral: NDArray[np.float32]
    differences: NDArray[np.float32]
    stored: dict[str, bytes] = field(default_factory=dict)
    loss: dict[str, float] = field(default_factory=dict)


def averaged_levels(source: Source, pyramid: Pyramid, codec: Codec) -> Iterator[Level]:
    """What engines make by themselves: every map averaged as plain numbers, and then stored."""
    scale = source.difference_scale
    maps = [source.model.neutral, *source.model.differences]
    for neutral, *differences in zip(*(pyramid.levels(one) for one in maps), strict=True):
        seen = to_float(codec.round_trip(np.rint(neutral * 255).astype(np.uint8)))
        steps = np.stack([codec.round_trip(one) for one in to_steps(np.stack(differences), scale)])
        yield Level(seen, from_steps(steps, scale[:, None, None]))


def fitted_levels(
    source: Source,
    pyramid: Pyramid,
    plain: Sequence[Level],
    stacks: Sequence[NDArray[np.uint16]],
    codec: Codec,
    upside_down: bool = False,
) -> Iterator[Level]:
    """Levels that are best for all expressions under the codec: what it loses of a map, the next ones make up for.

    Parameters
    ----------
    source : the pack.
    pyramid : which texels count.
    plain : every map averaged on its own; where expressions do not say what is better, it stays so.
    stacks : how every expression should look, from :func:`facezip.export.mips.targets`.
    codec : how maps are stored.
    upside_down : whether ``stored`` begins with the last row, for engines that keep textures so.
    """
    lights = list(pyramid.light(source.model.neutral))
    for number, light in enumerate(track(lights, "Coding", len(lights))):
        store = _Store(codec, pyramid.shares[number] > 0, upside_down)
        yield _fit(source, light, plain[number].differences, stacks[number], pyramid.fills[number], store)


class _Store:
    """Codes maps of one level, and remembers the bytes and what they lost."""

    def __init__(self, codec: Codec, covered: NDArray[np.bool_], upside_down: bool) -> None:
        self._codec, self.covered, self._turn = codec, covered, -1 if upside_down else 1
        self.stored: dict[str, bytes] = {}
        self.loss: dict[str, float] = {}

    def __call__(self, name: str, values: NDArray[np.float32]) -> NDArray[np.uint8]:
        """What a sampler sees of ``(h, w, C)`` values in 0..255."""
        texels = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        self.stored[name] = self._codec.store(texels[:: self._turn])
        seen = self._codec.load(self.stored[name], texels.shape)[:: self._turn]
        gap = seen.astype(np.float32) - texels
        self.loss[name] = float(np.sqrt(np.square(gap[self.covered]).mean()))
        return seen


def _fit(
    source: Source,
    light: NDArray[np.float32],
    plain: NDArray[np.float32],
    stack: NDArray[np.uint16],
    fill: Fill,
    store: _Store,
) -> Level:
    """One level: the neutral first, then each difference as ``plain`` with a correction for what is still wrong."""
    neutral = to_float(store("neutral", light * 255))
    level = Level(neutral, np.zeros_like(plain), store.stored, store.loss)
    samples = _wrong(as_model(source, Level(level.neutral, plain)), stack, store.covered)
    weights = np.ascontiguousarray(source.model.weights.transpose(1, 3, 0, 2))
    corrections = np.zeros_like(plain)
    for slot, scale in reversed([*enumerate(source.difference_scale)]):
        correction = solve_texture(samples, weights, corrections, slot)
        steps = (plain[slot] + correction) * (255 / np.maximum(scale, 1e-30)) + ZERO
        level.differences[slot] = from_steps(store(f"difference_{slot}", fill(steps)), scale)
        corrections[slot] = level.differences[slot] - plain[slot]
    return level


def _wrong(model: CompressedTextures, stack: NDArray[np.uint16], covered: NDArray[np.bool_]) -> Samples:
    """What a model lacks of the expressions as they should look, as the fit takes it: in steps, around the middle."""
    middle = WIDE // 2
    lacking = np.empty_like(stack)
    for n, name in enumerate(model.expressions):
        gap = (stack[n] / np.float32(WIDE) - model.reconstruct(name)) * np.float32(middle)
        lacking[n] = np.rint(gap) + middle
    return Samples(lacking, np.full_like(stack[0], middle), np.float32(1 / middle), covered.astype(np.float32))


def as_model(source: Source, level: Level) -> CompressedTextures:
    """A level in the place of the pack's textures, under the same weight maps."""
    return CompressedTextures(
        level.neutral, level.differences, source.model.weights, source.model.expressions, source.model.method
    )
