"""All levels of a sheet's textures as they lie in an engine's memory, fitted to what a block codec keeps of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.codecs import Codec
from facezip.character.samples import Samples
from facezip.export.mips import WIDE, Pyramid
from facezip.export.sheets import Fill, Sheet
from facezip.files.images import to_float
from facezip.fit.sweep import solve_texture
from facezip.machine.progress import track
from facezip.pack.model import CompressedTextures


@dataclass
class Level:
    """One level of all textures, as stored and as a sampler sees it.

    Attributes
    ----------
    neutral, differences : ``(h, w, C)`` and ``(R, h, w, C)`` float32, fitted texels.
    stored : the codec's bytes, by the names of the sheet's textures.
    loss : by the same names, the RMSE that storing added to a texture, in units of its 0..255 texels inside the chart.
    """

    neutral: NDArray[np.float32]
    differences: NDArray[np.float32]
    stored: dict[str, bytes] = field(default_factory=dict)
    loss: dict[str, float] = field(default_factory=dict)


def averaged_levels(sheet: Sheet, pyramid: Pyramid, codec: Codec) -> Iterator[Level]:
    """What engines make by themselves: every texture averaged as plain numbers, and then stored."""
    stored = to_float(sheet.packed(sheet.model.neutral, sheet.neutral_bits))
    for neutral, *differences in zip(*(pyramid.levels(one) for one in (stored, *sheet.model.differences)), strict=True):
        seen = sheet.unpacked(codec.round_trip(np.rint(neutral * 255).astype(np.uint8)))
        steps = [codec.round_trip(sheet.steps(one, slot)) for slot, one in enumerate(differences)]
        yield Level(seen, np.stack([sheet.difference(one, slot) for slot, one in enumerate(steps)]))


def fitted_levels(
    sheet: Sheet,
    pyramid: Pyramid,
    plain: Sequence[Level],
    stacks: Sequence[NDArray[np.uint16]],
    codec: Codec,
    upside_down: bool = False,
) -> Iterator[Level]:
    """Levels that are best for all expressions under the codec: what it loses of a texture, the next make up for.

    Parameters
    ----------
    sheet : the maps.
    pyramid : which texels count.
    plain : every texture averaged on its own; where expressions do not say what is better, it stays so.
    stacks : how every expression should look, from :func:`facezip.export.mips.targets`.
    codec : how textures are stored.
    upside_down : whether ``stored`` begins with the last row, for engines that keep textures so.
    """
    neutrals = list(pyramid.looks(sheet, sheet.model.neutral))
    for number, neutral in enumerate(track(neutrals, "Coding", len(neutrals))):
        store = _Store(codec, pyramid.shares[number] > 0, upside_down)
        yield _fit(sheet, neutral, plain[number].differences, stacks[number], pyramid.fills[number], store)


class _Store:
    """Codes textures of one level, and remembers the bytes and what they lost."""

    def __init__(self, codec: Codec, covered: NDArray[np.bool_], upside_down: bool) -> None:
        self._codec, self.covered, self._turn = codec, covered, -1 if upside_down else 1
        self.stored: dict[str, bytes] = {}
        self.loss: dict[str, float] = {}

    def __call__(self, name: str, texels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """What a sampler sees of ``(h, w, C)`` texels."""
        self.stored[name] = self._codec.store(texels[:: self._turn])
        seen = self._codec.load(self.stored[name], texels.shape)[:: self._turn]
        gap = seen.astype(np.float32) - texels
        self.loss[name] = float(np.sqrt(np.square(gap[self.covered]).mean()))
        return seen


def _fit(
    sheet: Sheet,
    look: NDArray[np.float32],
    plain: NDArray[np.float32],
    stack: NDArray[np.uint16],
    fill: Fill,
    store: _Store,
) -> Level:
    """One level: the neutral first, then each difference as ``plain`` with a correction for what is still wrong."""
    first, *names = sheet.textures
    neutral = sheet.unpacked(store(first, sheet.packed(look, 8).astype(np.uint8)))
    level = Level(neutral, np.zeros_like(plain), store.stored, store.loss)
    samples = _wrong(as_model(sheet, Level(level.neutral, plain)), stack, store.covered)
    weights = np.ascontiguousarray(sheet.model.weights.transpose(1, 3, 0, 2))
    corrections = np.zeros_like(plain)
    for slot, name in reversed([*enumerate(names)]):
        correction = solve_texture(samples, weights, corrections, slot)
        texels = sheet.steps(fill(plain[slot] + correction), slot)
        level.differences[slot] = sheet.difference(store(name, texels), slot)
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


def as_model(sheet: Sheet, level: Level) -> CompressedTextures:
    """A level in the place of the pack's textures, under the same weight maps."""
    return replace(sheet.model, neutral=level.neutral, differences=level.differences)
