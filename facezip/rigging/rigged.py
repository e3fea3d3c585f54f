"""A compressed character whose expressions are the shapes of a rig: what animators drive (equation 12)."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.character.tiles import shifted
from facezip.errors import ErrorCode, FaceZipError
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
    """The same neutral and difference textures, with weight maps and displacements of M generated shapes.

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
        weights = {tile: pseudo_inverse(maps, examples) for tile, maps in model.weights.items()}
    else:
        weights, damping = _geometry_aware(model, model.meshes, rig)
    meshes = replace(model.meshes, vertices=model.meshes.neutral + rig.deltas)
    return Rigged(replace(model, weights=weights, expressions=shapes, meshes=meshes), damping)


def _geometry_aware(
    model: CompressedTextures, meshes: Meshes, rig: Rig
) -> tuple[dict[int, NDArray[np.float32]], float]:
    """Weight maps ``(M, h, w, R)`` by tile, and the damping that they share."""
    examples, aware = Examples.of(rig.weights), {}
    for tile, weights in model.weights.items():
        size = (weights.shape[1], weights.shape[2])
        if size == (1, 1):
            reason = "uniform weights have no place to put a wrinkle; take pseudo-inverse maps, or another method"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"geometry-aware weight maps: {reason} than pca")
        reach = activity(shifted(meshes.topology, tile), rig.deltas, size)
        aware[tile] = GeometryAware(examples, reach)
    damping = best_damping(
        [(aware[tile], weights, _importance(model, tile)) for tile, weights in model.weights.items()]
    )
    return {tile: aware[tile].maps(weights, damping) for tile, weights in model.weights.items()}, damping


def _importance(model: CompressedTextures, tile: int) -> NDArray[np.float64]:
    """``(R,)``: what a slot's squared error counts, the mean square of its textures; all maps count alike."""
    total = np.zeros(next(iter(model.weights.values())).shape[3])
    for kind in model.maps:
        squares = np.mean(np.square(model.parts[kind.name, tile].differences, dtype=np.float64), axis=(1, 2, 3))
        total += squares / max(squares.sum(), np.finfo(np.float64).tiny)
    return total
