"""The refined fit with a block codec in the loop: every map is fitted to what the codec gave back of the others.

What a codec loses of one map, those that are stored after it make up for. So the neutral is stored first, the
differences are solved and stored one after the other, then the weight maps image by image, and again.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from facezip.character.maps import Key, Map
from facezip.character.samples import BESIDE_THE_FACE, Samples
from facezip.character.scans import Character
from facezip.files.images import Texels, to_float
from facezip.fit.importance import map_factors, weighted_samples
from facezip.fit.refine import fit_weights
from facezip.fit.storage import Place, Storage
from facezip.fit.sweep import joint_system, solve_texture
from facezip.fit.weights import WeightSystem, solve_weights
from facezip.machine.progress import track
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.quantise import quantise

# Weights that are coded in blocks should be smoother than those that are stored as they are.
SMOOTHNESS = 1e-2
ALTERNATIONS = 4


def fit_coded(
    character: Character, differences: int, weight_scale: int, storage: Storage, alternations: int = ALTERNATIONS
) -> CompressedTextures:
    """What a shader sees of the refined fit once it is stored.

    Parameters
    ----------
    character : the textures; their masks weight every texel's squared error, and each map counts as in
        :func:`facezip.compress`.
    differences : R, at most the number of expressions is used.
    weight_scale : how many times smaller weight maps are.
    storage : the codecs to fit to; its ``files`` become those of the result.
    alternations : how often all maps are stored; a few are enough.
    """
    slots, factors = min(differences, len(character.expressions)), map_factors(character, {})
    parts: dict[Key, Part] = {}
    weights: dict[int, NDArray[np.float32]] = {}
    for tile in character.tiles:
        tasks = {
            kind: weighted_samples(character.stacks[kind.name, tile], factors[kind.name], beside=BESIDE_THE_FACE)
            for kind in character.maps
        }
        maps, weights[tile] = _coded_tile(tile, tasks, slots, weight_scale, storage, alternations)
        parts |= {(kind.name, tile): part for kind, part in maps.items()}
    return CompressedTextures("refined", character.expressions, character.maps, parts, weights, character.meshes)


def _coded_tile(
    tile: int, samples: dict[Map, Samples], slots: int, weight_scale: int, storage: Storage, alternations: int
) -> tuple[dict[Map, Part], NDArray[np.float32]]:
    """The maps of one tile, and the weight maps ``(N, h, w, R)`` that they share."""
    neutrals = {
        kind: storage.neutral(to_float(some.neutral), kind, (kind.name, tile, "neutral"))
        for kind, some in samples.items()
    }
    samples = {kind: replace(some, neutral=_as_stored(neutrals[kind], some)) for kind, some in samples.items()}
    weights = _mixed(fit_weights([*samples.values()], slots, weight_scale, SMOOTHNESS, effort="start"))
    for group in storage.groups(slots):
        weights[:, group] = _stored(weights[:, group], storage, ("weights", tile, group.start))
    textures = {kind: np.zeros((slots, *neutral.shape), np.float32) for kind, neutral in neutrals.items()}
    for _ in track(range(alternations), "Coding", alternations):
        for slot in reversed(range(slots)):
            for kind, some in samples.items():
                texture = solve_texture(some, weights, textures[kind], slot)
                textures[kind][slot] = storage.difference(texture, some.importance, (kind.name, tile, slot))
        system = joint_system([*samples.values()], weights, [*textures.values()])
        system.regularise(system.mean_diagonal, SMOOTHNESS)
        weights = _coded_weights(system, weights, storage, tile)
    maps = np.ascontiguousarray(weights.transpose(2, 0, 3, 1))
    return {kind: Part(neutral, textures[kind]) for kind, neutral in neutrals.items()}, maps


def coded_afterwards(model: CompressedTextures, storage: Storage) -> CompressedTextures:
    """What a shader sees of a model that was fitted without regard to how its maps are stored."""
    rounded, kinds = quantise(model).dequantised(), {kind.name: kind for kind in model.maps}
    parts = {key: _coded_part(part, kinds[key[0]], storage, key[1]) for key, part in rounded.parts.items()}
    weights = {tile: _coded_afterwards(maps, storage, tile) for tile, maps in model.weights.items()}
    return replace(model, parts=parts, weights=weights)


def _coded_part(part: Part, kind: Map, storage: Storage, tile: int) -> Part:
    everywhere = np.ones(part.neutral.shape[:2], np.float32)
    differences = [
        storage.difference(texture, everywhere, (kind.name, tile, slot))
        for slot, texture in enumerate(part.differences)
    ]
    neutral = storage.neutral(part.neutral, kind, (kind.name, tile, "neutral"))
    return replace(part, neutral=neutral, differences=np.stack(differences))


def _coded_afterwards(maps: NDArray[np.float32], storage: Storage, tile: int) -> NDArray[np.float32]:
    slots = maps.transpose(1, 0, 3, 2)
    groups = [
        storage.coded_weights(slots[:, :, group], ("weights", tile, group.start))
        for group in storage.groups(maps.shape[3])
    ]
    return np.concatenate(groups, axis=2).transpose(1, 0, 3, 2)


def _mixed(weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """All slots ``(h, R, N, w)`` alike: a codec spends the same bytes on each, so none should hold more than others.

    Any orthogonal mixture of balanced slots is as good before coding. That of the discrete cosines makes their energies
    about equal, and so the sum over slots of a texture's error times the size of its weights smallest.
    """
    mixture = dct(np.eye(weights.shape[1]), norm="ortho", axis=0).astype(np.float32)
    mixed: NDArray[np.float32] = np.einsum("ij,hjnw->hinw", mixture, weights)
    return np.ascontiguousarray(mixed)


def _coded_weights(
    system: WeightSystem, start: NDArray[np.float32], storage: Storage, tile: int
) -> NDArray[np.float32]:
    """The weight maps ``(h, R, N, w)`` of a system, solved and stored image after image."""
    right, weights = system.right.copy(), solve_weights(system, start)
    for group in reversed(storage.groups(weights.shape[1])):
        free = np.ascontiguousarray(system.matrix[:, : group.stop, : group.stop])
        rest = WeightSystem(free, np.ascontiguousarray(right[:, : group.stop]))
        weights[:, : group.stop] = solve_weights(rest, np.ascontiguousarray(weights[:, : group.stop]))
        weights[:, group] = _stored(weights[:, group], storage, ("weights", tile, group.start))
        for slot in range(group.start, group.stop):
            right[:, : group.start] -= _coupled(system.matrix[:, : group.start, slot], weights[:, slot])
    return weights


def _stored(weights: NDArray[np.float32], storage: Storage, place: Place) -> NDArray[np.float32]:
    """What is left of the weight maps ``(h, R, N, w)`` of one group."""
    return storage.coded_weights(weights.swapaxes(1, 2), place).swapaxes(1, 2)


def _coupled(matrix: NDArray[np.float32], maps: NDArray[np.float32]) -> NDArray[np.float32]:
    """What one slot's maps ``(h, N, w)`` contribute to the equations ``(h, R, N, w)`` of others."""
    height, count, width = maps.shape
    padded = np.pad(maps, ((1, 1), (0, 0), (1, 1)))
    total = np.zeros((height, matrix.shape[1], count, width), np.float32)
    for cell in range(9):
        neighbour = padded[cell // 3 : cell // 3 + height, :, cell % 3 : cell % 3 + width]
        total += matrix[:, :, cell, None] * neighbour[:, None]
    return total


def _as_stored(neutral: NDArray[np.float32], samples: Samples) -> Texels:
    """Texels in [0, 1] in the units and the type of the samples' textures."""
    values = neutral / samples.scale
    if samples.neutral.dtype.kind == "u":
        values = np.rint(values)
    return np.ascontiguousarray(values.astype(samples.neutral.dtype))
