"""A compressed character whose expressions are the shapes of a rig: what animators drive (equation 12)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.pack.model import CompressedTextures
from facezip.rigging.evidence import Estimate, estimate
from facezip.rigging.fit import Rig
from facezip.rigging.likeness import Poses
from facezip.rigging.weightmaps import Examples, pseudo_inverse

MAPS = ("geometry-aware", "pseudo-inverse")


@dataclass(frozen=True, eq=False)
class Rigged:
    """The model of the generated shapes, and how its weight maps came about.

    Attributes
    ----------
    model : M shapes as expressions.
    estimates : of geometry-aware maps, by tile; none for the paper's.
    """

    model: CompressedTextures
    estimates: Mapping[int, Estimate] = field(default_factory=dict)

    @property
    def damping(self) -> float | None:
        """Noise over signal: the median of 1/ρ over all texels where scans show anything; None for the paper's maps."""
        strengths = np.concatenate([np.zeros(0), *(made.strength.ravel() for made in self.estimates.values())])
        shown = strengths[strengths > 0]
        return float(np.median(1 / shown)) if len(shown) else None


def rigged(
    character: Character, model: CompressedTextures, rig: Rig, shapes: tuple[str, ...], maps: str = MAPS[0]
) -> Rigged:
    """The same neutrals and difference textures, with weight maps and displacements of M generated shapes.

    All maps of a tile share its weight maps, and so have the shapes as soon as one has.

    Parameters
    ----------
    character : the scans: what they disagree on is noise.
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
    meshes = replace(model.meshes, vertices=model.meshes.neutral + rig.deltas)
    shaped = replace(model, expressions=shapes, meshes=meshes)
    if maps == "pseudo-inverse":
        examples = Examples.of(rig.weights)
        return Rigged(
            replace(shaped, weights={tile: pseudo_inverse(own, examples) for tile, own in model.weights.items()})
        )
    if any(own.shape[1:3] == (1, 1) for own in model.weights.values()):
        reason = "uniform weights have no place to put a wrinkle; take pseudo-inverse maps, or another method"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"geometry-aware weight maps: {reason} than pca")
    scans = model.meshes
    poses = Poses.of(scans.neutral, scans.deltas, rig.deltas, scans.topology.faces, rig.weights)
    made = estimate(character, poses, model.weights)
    return Rigged(replace(shaped, weights={tile: own.weights for tile, own in made.items()}), made)
