"""What is measured for ``facezip bench clean``: scans and packs against the truth, before and after each step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.cleaning.steps import STEPS, clean
from facezip.documents.document import Document
from facezip.files.images import to_float
from facezip.fit.methods import compress
from facezip.machine.conditions import Conditions
from facezip.machine.progress import track
from facezip.pack.quantise import quantise
from scenes.character import Person, make_character
from scenes.face.expressions import expression_weights

# Detail is what lies above this part of the sampling frequency.
FINE = 0.25
KEPT = tuple(STEPS[:count] for count in range(len(STEPS) + 1))

Texture = NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class CleanErrors:
    """RMSE to the truth, 0..255 inside the mask.

    Attributes
    ----------
    neutral : of the neutral.
    scans, pack : means over expressions, of what is compressed and of what the refined method makes of it.
    detail : the power of the neutral above a quarter of the sampling frequency over that of the true one.
    """

    neutral: float
    scans: float
    pack: float
    detail: float


@dataclass(frozen=True, kw_only=True)
class CleanBenchConditions(Conditions):
    """What was cleaned."""

    character: str
    resolution: tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class CleanBenchDocument(Document):
    """What cleaning does to scans and packs, against the known truth.

    Attributes
    ----------
    people : by seed, and by the last step taken: ``none``, then each of ``--clean``.
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-clean/1"] = "facezip-bench-clean/1"
    people: Mapping[str, Mapping[str, CleanErrors]]
    conditions: CleanBenchConditions


def bench_clean(resolution: int, seed: int) -> dict[str, CleanErrors]:
    """Errors to the truth by the last step taken: ``none``, and :data:`STEPS`."""
    person, scans = Person.make(resolution, seed), make_character(resolution, seed=seed)
    true = [person.texture(weights) for weights in expression_weights(len(scans.expressions), seed).values()]
    steps = track(KEPT, "Cleaning step by step", len(KEPT))
    return {steps_[-1] if steps_ else "none": _errors(clean(scans, steps_).character, person, true) for steps_ in steps}


def _errors(scans: Character, person: Person, true: list[Texture]) -> CleanErrors:
    stack, names = scans.first, scans.expressions
    model = quantise(compress(scans)).dequantised()
    key = (scans.maps[0].name, scans.tiles[0])
    neutral = to_float(stack.neutral)

    def rmse(one: Texture, other: Texture) -> float:
        return float(255 * np.sqrt(np.average(np.square(one - other).mean(axis=2), weights=stack.weight)))

    pairs = list(zip(names, stack.textures, true, strict=True))
    return CleanErrors(
        neutral=rmse(neutral, person.albedo),
        scans=sum(rmse(to_float(texture), truth) for _, texture, truth in pairs) / len(pairs),
        pack=sum(rmse(model.texels({name: 1.0}, key), truth) for name, _, truth in pairs) / len(pairs),
        detail=_fine(neutral, stack.weight) / _fine(person.albedo, stack.weight),
    )


def _fine(image: Texture, mask: NDArray[np.float32]) -> float:
    """The power of the square in the middle of the face, half its size, above :data:`FINE`."""
    spans = [np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0)]
    rows, columns = (slice((3 * span[0] + span[-1]) // 4, (span[0] + 3 * span[-1]) // 4) for span in spans)
    part = image[rows, columns].mean(axis=2)
    tapered = (part - part.mean()) * np.hanning(part.shape[0])[:, None] * np.hanning(part.shape[1])
    frequencies = np.hypot(np.fft.fftfreq(part.shape[0])[:, None], np.fft.fftfreq(part.shape[1]))
    return float(np.square(np.abs(np.fft.fft2(tapered)))[frequencies > FINE].sum())
