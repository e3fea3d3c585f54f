"""The ways to compress, by name: each fits every map on every tile in one go.

Weight maps that several maps share minimise the sum of the maps' errors, so their normal equations are sums too: of
Gram matrices for principal components and clusters, of the weights' sparse systems in the refined fit. Difference
textures are solved map by map under the shared weights. Tiles share what lives on the mesh or is one number for all:
masks and principal components; the refined weight maps of a tile are its own. One albedo on one tile is a sum of one.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from facezip.character.scans import Character
from facezip.fit.fixed_masks import fixed_masks
from facezip.fit.given import GivenMasks
from facezip.fit.importance import Importance, by_key, map_factors
from facezip.fit.kept import KeptRegion
from facezip.fit.locks import Lock
from facezip.fit.painted import Painted
from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.stitching import unpermuted
from facezip.fit.pca import combine_differences, principal_weights
from facezip.fit.refined import refined
from facezip.fit.settings import Settings
from facezip.fit.stitched import paper, stitched
from facezip.fit.task import Fit, Task
from facezip.pack.model import CompressedTextures


def compress(
    character: Character,
    method: str = "refined",
    *,
    differences: int = 4,
    weight_scale: int = 8,
    masks: int = 53,
    restarts: int = 100,
    seed: int = 0,
    nonnegative: bool = False,
    sparse: int | None = None,
    effort: str = "default",
    given_masks: GivenMasks | None = None,
    locks: Sequence[Lock] = (),
    painted: Sequence[Painted] = (),
    kept: KeptRegion | None = None,
    importance: Importance | None = None,
    map_weights: Mapping[str, float] | None = None,
) -> CompressedTextures:
    """Fit neutrals, R difference textures of every map and N weight maps of every tile to a character (equation 1).

    Parameters
    ----------
    character : neutral and expressions.
    method : ``"refined"``, ``"paper"``, ``"paper-optimised"`` (with our search of the permutation),
        ``"paper-unpermuted"`` (its ablation), ``"pca"``, or ``"masks"`` (weight maps that are sums of fixed masks).
    differences, weight_scale, masks, restarts, seed, nonnegative, sparse, effort : see
        :class:`facezip.fit.settings.Settings`.
    given_masks : those of the method ``"masks"``; None for ``masks`` of the paper's.
    locks : difference textures that stay as they are (refined).
    painted : weight maps that stay as they are (refined, not sparse).
    kept : a region that stays as it is in an older pack, whose neutral, number of differences, size of weight maps and
        ranges the fit has (refined, not sparse, nothing locked or painted).
    importance : ``(H, W)`` ≥ 0, of the albedo's size, what a texel's squared error counts besides the mask (refined,
        masks); or one for each map and tile. Maps without one take the albedo's.
    map_weights : how much a map counts, > 0. With 1, the default, the expressions' differences of each map count alike
        in sum, whatever its units, channels and size; those with an importance of their own count by that.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a setting outside its range, or what its method cannot do, ``UNKNOWN_NAME`` for the weight of
        a map that there is not, or painted weight maps of an expression or a tile, ``TOO_MANY_MASKS``;
        ``SIZE_MISMATCH`` or ``BAD_TEXELS`` for an importance that does not fit; and what
        :class:`facezip.fit.given.GivenMasks` raises.
    """
    settings = Settings(differences, weight_scale, masks, restarts, seed, nonnegative, sparse, effort)
    settings.check(method)
    images = by_key(importance, character)
    factors = map_factors(character, map_weights or {}, {name for name, _ in images})
    task = Task(character, settings, factors, images, given_masks, tuple(locks), tuple(painted), kept)
    task.check(method)
    fit = METHODS[method](task)
    whole = character.expressions, character.maps, fit.parts, fit.weights, character.meshes, fit.weight_ranges
    return CompressedTextures(method, *whole)


def _pca(task: Task) -> Fit:
    stacks = task.character.stacks
    components = principal_weights([task.samples(key, stack) for key, stack in stacks.items()], task.slots)
    parts = {key: task.part(key, combine_differences(stack, components.T)) for key, stack in stacks.items()}
    uniform = np.ascontiguousarray(components[:, None, None, :])
    return Fit(parts, dict.fromkeys(task.character.tiles, uniform))


METHODS: dict[str, Callable[[Task], Fit]] = {
    "refined": refined,
    "paper": paper,
    "paper-optimised": lambda task: stitched(task, beam_search),
    "paper-unpermuted": lambda task: stitched(task, unpermuted),
    "pca": _pca,
    "masks": fixed_masks,
}
