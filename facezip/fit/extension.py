"""New expressions under the difference textures of a pack: only their weights are solved.

The equations are those of the fit (:mod:`facezip.fit.sweep`) with the textures known, so one system tells all: free
weight maps by conjugate gradients, then within the range that the pack stores weights in, which gives the old maps'
bytes their meaning; activations of masks projected on them; one number for each slot where weights are uniform.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.meshes import Meshes
from facezip.character.neutrals import unpacked_neutral
from facezip.character.samples import BESIDE_THE_FACE, Samples
from facezip.character.scans import Character
from facezip.files.images import as_texels, to_float
from facezip.fit.activations import ActivationSystem, Bounds, project, solve_activations
from facezip.fit.importance import map_factors, weighted_samples
from facezip.fit.nonnegative import Limits, solve_bounded
from facezip.fit.sweep import joint_system
from facezip.fit.weights import WeightSystem, solve_weights
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import StoredTextures, StoredWeights, weight_bytes

# The system is solved once and for all, from nothing.
ROUNDS = 12
BOUNDED_SWEEPS = 12
ACTIVATION_SWEEPS = 400


def extended(
    stored: StoredTextures, model: CompressedTextures, character: Character, map_weights: Mapping[str, float]
) -> tuple[StoredTextures, dict[str, float]]:
    """A pack's textures under weights of a character's expressions too, which come after its own.

    Parameters
    ----------
    stored, model : the pack as it is stored, and as a reader sees it.
    character : beside the pack's neutral (:func:`beside_neutral_of`), with none of the pack's expressions.
    map_weights : how much a map counts, as of :func:`facezip.compress`.

    Returns
    -------
    extended : what to write; the textures and the old weights are the same arrays.
    cut : for each new expression, the share of its weights that would lie beyond the range of the pack's.
    """
    factors = map_factors(character, map_weights)
    sizes = dict(zip(model.tiles, model.footprint.weight_sizes, strict=True))
    tiles = {tile: _system(model, character, tile, sizes[tile], factors) for tile in sizes}
    names = (*stored.expressions, *character.expressions)
    more: Mapping[int, StoredWeights] | MaskedWeights
    if isinstance(stored.weights, MaskedWeights):
        more, cut = _with_activations(stored.weights, tiles), np.zeros(len(character.expressions))
    elif model.footprint.layers == 0:
        more, cut = _with_uniform(stored.weights, tiles), np.zeros(len(character.expressions))
    else:
        solved = {tile: _with_maps(stored.weights[tile], tiles[tile]) for tile in tiles}
        more = {tile: maps for tile, (maps, _) in solved.items()}
        cut = np.mean([share for _, share in solved.values()], axis=0)
    whole = replace(stored, expressions=names, weights=more, meshes=_with_meshes(stored.meshes, character))
    return whole, dict(zip(character.expressions, cut.tolist(), strict=True))


def beside_neutral_of(stored: StoredTextures, character: Character) -> Character:
    """The scans beside the pack's own neutral, in the type of their texels: a reader will add differences to that."""
    stacks = {}
    for key, stack in character.stacks.items():
        theirs = unpacked_neutral(stored.parts[key].neutral, character.kind(key[0]))
        stacks[key] = replace(stack, neutral=as_texels(to_float(theirs), stack.neutral.dtype))
    return replace(character, stacks=stacks)


def _system(
    model: CompressedTextures, character: Character, tile: int, size: tuple[int, ...], factors: Mapping[str, float]
) -> WeightSystem:
    """The equations of all weight maps of the new expressions on a tile, without regularisation."""
    keys: Sequence[Key] = [(kind.name, tile) for kind in character.maps]
    samples: list[Samples] = [
        weighted_samples(character.stacks[key], factors[key[0]], beside=BESIDE_THE_FACE) for key in keys
    ]
    textures = [np.require(model.parts[key].differences, requirements="C") for key in keys]
    nothing = np.zeros((size[0], len(textures[0]), len(character.expressions), size[1]), np.float32)
    return joint_system(samples, nothing, textures)


def _with_maps(stored: StoredWeights, system: WeightSystem) -> tuple[StoredWeights, NDArray[np.float64]]:
    """Weight maps after those that are stored, and which share of each expression's lies beyond their range."""
    system.regularise(system.mean_diagonal)
    free = np.zeros_like(system.right)
    for _ in range(ROUNDS):
        free = solve_weights(system, free)
    low, high = stored.offset, stored.offset + stored.span
    column = slice(None), None, None
    start, count = np.clip(free, low[column], high[column]), free.shape[2]
    each = (len(low), count)
    bounds = np.broadcast_to(low[:, None], each), np.broadcast_to(high[:, None], each)
    bounded = solve_bounded(system, start, Limits(*bounds), BOUNDED_SWEEPS)
    # A byte of a range says nothing finer than half a step.
    beyond = np.abs(bounded - free) > stored.span[column] / 255
    texels = weight_bytes(bounded.transpose(2, 0, 3, 1), low, stored.span)
    return replace(stored, texels=np.concatenate([stored.texels, texels])), beyond.mean(axis=(0, 1, 3))


def _with_uniform(stored: Mapping[int, StoredWeights], tiles: Mapping[int, WeightSystem]) -> dict[int, StoredWeights]:
    """The numbers of the old expressions, and those of the new ones, the same on all tiles."""
    matrix = np.sum([system.matrix[0, :, :, 4, 0] for system in tiles.values()], axis=0, dtype=np.float64)
    right = np.sum([system.right[0, :, :, 0] for system in tiles.values()], axis=0, dtype=np.float64)
    solved = np.linalg.lstsq(matrix, right, rcond=None)[0].T.astype(np.float32)
    return {
        tile: replace(one, texels=np.concatenate([one.texels, solved[:, None, None]])) for tile, one in stored.items()
    }


def _with_activations(stored: MaskedWeights, tiles: Mapping[int, WeightSystem]) -> MaskedWeights:
    """Activations after those that are stored: in 0..1 where those are, and in no layer where a mask has none."""
    parts = []
    for tile, system in tiles.items():
        system.regularise(system.mean_diagonal)
        parts.append(project(system, stored.masks[tile]))
    joint = ActivationSystem.joint(parts)
    allowed = (stored.activations != 0).any(axis=0)
    bounds = Bounds.of(allowed, stored.clamped)
    if stored.clamped:
        bounds = bounds.at_most_one
    start = np.zeros((len(joint.right), *allowed.shape))
    solved, _ = solve_activations(joint, start, bounds, ACTIVATION_SWEEPS)
    more = np.concatenate([stored.activations, solved.astype(np.float16)])
    return MaskedWeights(stored.names, stored.masks, more)


def _with_meshes(stored: Meshes | None, character: Character) -> Meshes | None:
    if stored is None:
        return None
    return replace(stored, vertices=np.concatenate([stored.vertices, character.meshes.vertices]))
