"""A compressed character whose expressions are the shapes of a rig: what animators drive (equation 12)."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.character.tiles import shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.rows import sum_rows
from facezip.pack.model import CompressedTextures
from facezip.rigging.activity import activity
from facezip.rigging.fit import Rig
from facezip.rigging.weightmaps import Examples, GeometryAware, best_damping, pseudo_inverse

MAPS = ("geometry-aware", "pseudo-inverse")


@dataclass(frozen=True, eq=False)
class Rigged:
    """The model of the generated shapes, and how its weight maps came about.

    Attributes
    ----------
    model : M shapes as expressions.
    damping : of geometry-aware maps, as chosen; None for the paper's.
    """

    model: CompressedTextures
    damping: float | None


def rigged(model: CompressedTextures, rig: Rig, shapes: tuple[str, ...], maps: str = MAPS[0]) -> Rigged:
    """The same neutrals and difference textures, with weight maps and displacements of M generated shapes.

    All maps of a tile share its weight maps, and so have the shapes as soon as one has.

    Parameters
    ----------
    model : of the scans, with their meshes, in the order of the rig's example weights.
    rig : the generated shapes and what every scan is made of.
    shapes : M names.
    maps : ``"geometry-aware"``, or the paper's ``"pseudo-inverse"``.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE``: an unknown choice of maps, a model without meshes, or geometry-aware maps of a model whose
        weights are uniform.
    """
    if maps not in MAPS:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"weight maps '{maps}': must be one of {', '.join(MAPS)}")
    if model.meshes is None:
        raise FaceZipError(ErrorCode.BAD_VALUE, "the model has no meshes: compress the character anew, with them")
    damping = None
    if maps == "pseudo-inverse":
        examples = Examples.of(rig.weights)
        weights = {tile: pseudo_inverse(scans, examples) for tile, scans in model.weights.items()}
    else:
        weights, damping = _geometry_aware(model, model.meshes, rig)
    meshes = replace(model.meshes, vertices=model.meshes.neutral + rig.deltas)
    return Rigged(replace(model, weights=weights, expressions=shapes, meshes=meshes), damping)


def _geometry_aware(
    model: CompressedTextures, meshes: Meshes, rig: Rig
) -> tuple[dict[int, NDArray[np.float32]], float]:
    """Weight maps ``(M, h, w, R)`` by tile, and the damping that they share."""
    sizes = {tile: (weights.shape[1], weights.shape[2]) for tile, weights in model.weights.items()}
    if (1, 1) in sizes.values():
        reason = "uniform weights have no place to put a wrinkle; take pseudo-inverse maps, or another method"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"geometry-aware weight maps: {reason} than pca")
    activities = {tile: activity(shifted(meshes.topology, tile), rig.deltas, size) for tile, size in sizes.items()}
    aware = GeometryAware.on(Examples.of(rig.weights), activities)
    damping = best_damping(aware, model.weights, _importance(model))
    return {tile: aware[tile].maps(weights, damping) for tile, weights in model.weights.items()}, damping


def _importance(model: CompressedTextures) -> dict[int, NDArray[np.float64]]:
    """``(R,)`` by tile: what a slot's squared error counts, the mean square of its textures; all maps count alike."""
    total = {tile: np.zeros(weights.shape[3]) for tile, weights in model.weights.items()}
    for kind in model.maps:
        squares = {tile: _mean_squares(model.parts[kind.name, tile].differences) for tile in total}
        energy = max(sum(some.sum() for some in squares.values()), np.finfo(np.float64).tiny)
        for tile, some in squares.items():
            total[tile] += some / energy
    return total


def _mean_squares(differences: NDArray[np.float32]) -> NDArray[np.float64]:
    """``(R,)`` of difference textures ``(R, H, W, C)``."""

    def sums(top: int, bottom: int) -> NDArray[np.float64]:
        return np.square(differences[:, top:bottom], dtype=np.float64).sum(axis=(1, 2, 3))

    return sum_rows(sums, differences.shape[1]) / differences[0].size
