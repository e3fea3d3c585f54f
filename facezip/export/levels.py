"""All levels of a sheet's textures as they lie in an engine's memory, fitted to what a block codec keeps of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.codecs import Codec
from facezip.character.samples import Samples
from facezip.export.fill import Fill
from facezip.export.mips import WIDE, Pyramid
from facezip.export.sheets import Sheet, in_bytes
from facezip.files.images import Texels, to_float
from facezip.fit.sweep import solve_texture
from facezip.machine import memory
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, sum_rows, write_rows
from facezip.pack.model import Part, blended_rows


@dataclass
class Level:
    """One level of all textures, as stored and as a sampler sees it.

    Attributes
    ----------
    part : neutral ``(h, w, C)`` and differences ``(R, h, w, C)``, texels.
    stored : the codec's bytes, by the names of the sheet's textures.
    loss : by the same names, the RMSE that storing added to a texture, in units of its 0..255 texels inside the chart.
    """

    part: Part
    stored: dict[str, NDArray[np.uint8]] = field(default_factory=dict)
    loss: dict[str, float] = field(default_factory=dict)


def averaged_levels(sheet: Sheet, part: Part, pyramid: Pyramid, codec: Codec) -> Iterator[Level]:
    """What engines make by themselves: every texture averaged as plain numbers, and then stored.

    ``part`` is the pack's, from :meth:`facezip.export.sheets.Sheet.dequantised`.
    """
    stored = to_float(sheet.neutral_image())
    for neutral, *differences in zip(*(pyramid.levels(one) for one in (stored, *part.differences)), strict=True):
        mean = codec.round_trip(_bytes_of(neutral))
        seen = memory.empty((len(differences), *differences[0].shape), np.float32)
        for slot, difference in enumerate(differences):
            shown = sheet.difference(codec.round_trip(sheet.steps(difference, slot)), slot)
            write_rows(shown.__getitem__, seen[slot])
        yield Level(Part(sheet.unpacked(mean), seen))


def fitted_levels(
    sheet: Sheet,
    part: Part,
    pyramid: Pyramid,
    plain: Sequence[Level],
    stacks: Sequence[NDArray[np.uint16]],
    codec: Codec,
    upside_down: bool = False,
) -> Iterator[Level]:
    """Levels that are best for all expressions under the codec: what it loses of a texture, the next make up for.

    Parameters
    ----------
    sheet, part : the maps, and what the pack holds of them.
    pyramid : which texels count.
    plain : every texture averaged on its own; where expressions do not say what is better, it stays so.
    stacks : how every expression should look, from :func:`facezip.export.mips.targets`.
    codec : how textures are stored.
    upside_down : whether ``stored`` begins with the last row, for engines that keep textures so.
    """
    weights = sheet.weights.transpose(1, 3, 0, 2)
    maps = by_rows(lambda rows: weights[rows], weights.shape, np.float32)
    for number, look in enumerate(track(pyramid.looks(sheet, part.neutral), "Coding", len(pyramid.sizes))):
        store = _Store(codec, pyramid.shares[number], upside_down)
        yield _fit(sheet, look, plain[number].part.differences, stacks[number], maps, pyramid.fills[number], store)


def _bytes_of(texels: NDArray[np.float32]) -> NDArray[np.uint8]:
    return by_rows(lambda rows: np.rint(texels[rows] * 255), texels.shape, np.uint8)


class _Store:
    """Codes textures of one level, and remembers the bytes and what they lost."""

    def __init__(self, codec: Codec, share: NDArray[np.float32], upside_down: bool) -> None:
        self._codec, self._share, self._turn = codec, share, -1 if upside_down else 1
        self.stored: dict[str, NDArray[np.uint8]] = {}
        self.loss: dict[str, float] = {}

    def __call__(self, name: str, texels: NDArray[np.uint8]) -> Texels:
        """What a sampler sees of ``(h, w, C)`` texels."""
        self.stored[name] = self._codec.store(texels[:: self._turn])
        seen: Texels = self._codec.load(self.stored[name], texels.shape)[:: self._turn]
        self.loss[name] = self._rmse(seen, texels)
        return seen

    def _rmse(self, seen: Texels, texels: NDArray[np.uint8]) -> float:
        def block(top: int, bottom: int) -> NDArray[np.float64]:
            covered, rows = self._share[top:bottom] > 0, slice(top, bottom)
            gap = in_bytes(seen[rows][covered]) - texels[rows][covered][..., : seen.shape[2]]
            return np.array([np.square(gap).sum(dtype=np.float64), gap.size])

        squares, count = sum_rows(block, len(texels))
        return float(np.sqrt(squares / count))


def _fit(
    sheet: Sheet,
    look: NDArray[np.float32],
    plain: NDArray[np.float32],
    stack: NDArray[np.uint16],
    weights: NDArray[np.float32],
    fill: Fill,
    store: _Store,
) -> Level:
    """One level: the neutral first, then each difference as ``plain`` with a correction for what is still wrong."""
    first, *names = sheet.textures
    neutral = sheet.unpacked(store(first, sheet.packed(look)))
    seen, corrections = memory.zeros(plain.shape, np.float32), memory.zeros(plain.shape, np.float32)
    samples = _wrong(sheet, Part(neutral, plain), stack, fill)
    for slot, name in reversed([*enumerate(names)]):
        wanted = fill(_combined(np.add, plain[slot], solve_texture(samples, weights, corrections, slot)))
        shown = sheet.difference(store(name, sheet.steps(wanted, slot)), slot)
        write_rows(shown.__getitem__, seen[slot])
        write_rows(_combined(np.subtract, shown, plain[slot]).__getitem__, corrections[slot])
    return Level(Part(neutral, seen), store.stored, store.loss)


def _combined(how: np.ufunc, one: NDArray[np.float32], other: NDArray[np.float32]) -> NDArray[np.float32]:
    return by_rows(lambda rows: how(one[rows], other[rows]), one.shape, np.float32)


def _wrong(sheet: Sheet, part: Part, stack: NDArray[np.uint16], fill: Fill) -> Samples:
    """What a level lacks of the expressions as they should look, as the fit takes it: in steps, around the middle."""
    middle = WIDE // 2
    shown = [blended_rows(part, weights) for weights in sheet.weights]

    def lacking(rows: slice) -> NDArray[np.uint16]:
        steps = np.empty_like(stack[:, rows])
        for n, blend in enumerate(shown):
            gap = (stack[n, rows] / np.float32(WIDE) - blend(rows)) * np.float32(middle)
            steps[n] = np.rint(gap) + middle
        return steps

    neutral = by_rows(lambda _: np.full(1, middle, np.uint16), stack.shape[1:], np.uint16)
    importance = by_rows(lambda rows: fill.covered[rows], fill.covered.shape, np.float32)
    texels = by_rows(lacking, stack.shape, np.uint16, axis=1)
    return Samples(texels, neutral, np.float32(1 / middle), importance)
