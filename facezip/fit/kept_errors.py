"""What a region that is kept costs: the error inside it, and outside."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.character.scans import Character, Stack
from facezip.fit.documents import KeptFacts
from facezip.fit.kept import KeptRegion
from facezip.machine.rows import by_rows
from facezip.pack.errors import pack_errors
from facezip.pack.measure import texels_seen


def kept_facts(scans: Character, kept: KeptRegion, pack: Path) -> KeptFacts:
    """Of a pack that was written."""
    albedo = scans.only(ALBEDO)
    sides = [_side(albedo, kept, inside) for inside in (True, False)]
    texels = [sum(texels_seen(stack) for stack in side.stacks.values()) for side in sides]
    errors = [
        pack_errors(side, pack)[ALBEDO].mean if seen > 0 else None for side, seen in zip(sides, texels, strict=True)
    ]
    return KeptFacts(regions=kept.names, share=texels[0] / sum(texels), rmse_inside=errors[0], rmse_outside=errors[1])


def _side(albedo: Character, kept: KeptRegion, inside: bool) -> Character:
    """The albedo with the face limited to the region, or to what is outside."""
    stacks = {key: _limited(stack, kept.inside[key], inside) for key, stack in albedo.stacks.items()}
    return replace(albedo, stacks=stacks)


def _limited(stack: Stack, region: NDArray[np.bool_], inside: bool) -> Stack:
    mask = stack.weight
    return replace(stack, mask=by_rows(lambda rows: mask[rows] * (region[rows] == inside), mask.shape, np.float32))
