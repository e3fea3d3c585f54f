"""What a fit of all expressions would reach, beside which an extension of a pack is judged."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, as_texels
from facezip.fit.given import GivenMasks
from facezip.fit.methods import compress
from facezip.machine import memory
from facezip.pack.errors import Errors, model_errors
from facezip.pack.masked import STEP, MaskedWeights
from facezip.pack.model import CompressedTextures


def full_fit_errors(
    pack: Path,
    model: CompressedTextures,
    scans: Character,
    new: Character,
    nonnegative: bool,
    map_weights: Mapping[str, float],
) -> Errors:
    """The errors of a character's new expressions after a fit of them and of all that a pack holds, of the same size.

    Parameters
    ----------
    pack : where it is, for messages.
    model : the pack, without the new expressions. Where ``scans`` lack one of its expressions, what the pack gives of
        it stands for its scan.
    scans, new : all that is given, and what is new of it, beside the pack's neutral.
    nonnegative : whether weights lie in 0..1.
    map_weights : how much a map counts.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for weight maps of a size that no fit makes.
    """
    together, masked = _together(model, scans, new), model.masked
    cost = model.footprint
    if masked is None and cost.layers == 0:
        fitted = compress(together, "pca", differences=cost.differences, map_weights=map_weights)
    elif cost.weight_scale is None:
        reason = "no fit makes weight maps of their size; give --quick, which leaves the fit of all beside it out"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {reason}")
    else:
        method, (given, layers) = ("masks", _given(masked)) if masked else ("refined", (None, cost.differences))
        fitted = compress(
            together,
            method,
            differences=layers,
            weight_scale=cost.weight_scale,
            nonnegative=nonnegative,
            given_masks=given,
            map_weights=map_weights,
        )
    return model_errors(new, fitted)


def _together(model: CompressedTextures, scans: Character, new: Character) -> Character:
    """The pack's expressions and the new ones, as scans."""
    names = (*model.expressions, *new.expressions)
    stacks = {}
    for key, stack in scans.stacks.items():
        textures: Texels = memory.empty((len(names), *stack.neutral.shape), stack.neutral.dtype.type)
        for n, name in enumerate(names):
            there = name in scans.expressions
            textures[n] = (
                scans.texels(name, key) if there else as_texels(model.texels({name: 1}, key), stack.neutral.dtype)
            )
            memory.ease()
        stacks[key] = Stack(stack.neutral, textures, stack.mask)
    vertices = np.repeat(new.meshes.neutral[None], len(names), axis=0)
    meshes = replace(new.meshes, vertices=vertices)
    return Character(new.name, names, meshes, new.maps, stacks)


def _given(masked: MaskedWeights) -> tuple[GivenMasks, int]:
    """The masks and layers that expressions use, the others of which an extension leaves alone, and how many layers."""
    images: dict[tuple[str, int], NDArray[np.float32]] = {
        (name, tile): STEP * masks[k].astype(np.float32)
        for tile, masks in masked.masks.items()
        for k, name in enumerate(masked.names)
    }
    used = (masked.activations != 0).any(axis=0)
    used = used[:, used.any(axis=0)]
    layers = {name: _where(row) for name, row in zip(masked.names, used, strict=True) if row.any()}
    shown = {key: image for key, image in images.items() if key[0] in layers}
    return GivenMasks(tuple(layers), shown, layers, nonnegative=masked.clamped), used.shape[1]


def _where(row: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple(np.flatnonzero(row).tolist())
