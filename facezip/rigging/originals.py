"""What a blend of a pack is compared with: equations (7) and (8) on textures that were never compressed."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float
from facezip.machine.rows import by_rows
from facezip.pack.belonging import check_sizes
from facezip.pack.model import CompressedTextures
from facezip.pack.same_neutral import warn_of_another
from facezip.rigging.weightmaps import Examples

RIG = "rig.json"
BLEND = "blend"


@dataclass(frozen=True, eq=False)
class Originals:
    """Blends of M names, out of the N uncompressed textures of a character.

    Attributes
    ----------
    character : the N expressions.
    names : M names that blends are made of.
    shares : ``(M, N)``, how much of every expression's difference is in each name; the identity for its own.
    neutral, deltas : ``(V, 3)`` and ``(M, V, 3)`` float32, the geometry of the names.
    definition : one sentence for a report.
    """

    character: Character
    names: tuple[str, ...]
    shares: NDArray[np.float64]
    neutral: NDArray[np.float32]
    deltas: NDArray[np.float32]
    definition: str

    def blended(self, weights: Mapping[str, float]) -> Character:
        """Scans of a blend β: a character whose one expression, :data:`BLEND`, has its textures and its mesh."""
        stacks = {}
        for key, stack in self.character.stacks.items():
            texels = self.texels(weights, key)
            stacks[key] = Stack(texels, texels[None], stack.mask)
        meshes = replace(self.character.meshes, neutral=self.neutral, vertices=self.vertices(weights)[None])
        return replace(self.character, expressions=(BLEND,), meshes=meshes, stacks=stacks)

    def texels(self, weights: Mapping[str, float], key: Key) -> NDArray[np.float32]:
        """I_0 + Σ_n (Σ_m β_m shares_mn) (I_n - I_0) of a map on a tile: ``(H, W, C)`` float32 clipped to [0, 1]."""
        mixed, stack = self._row(weights) @ self.shares, self.character.stacks[key]
        shares = {n: np.float32(mixed[n]) for n in np.flatnonzero(mixed)}

        def rows_of(rows: slice) -> NDArray[np.float32]:
            total = to_float(stack.neutral[rows]) * np.float32(1 - mixed.sum())
            for n, share in shares.items():
                total += share * to_float(stack.textures[n, rows])
            return np.clip(total, 0, 1)

        return by_rows(rows_of, stack.neutral.shape, np.float32)

    def vertices(self, weights: Mapping[str, float]) -> NDArray[np.float32]:
        """Equation (7): ``(V, 3)`` float32."""
        moved: NDArray[np.float32] = np.tensordot(self._row(weights).astype(np.float32), self.deltas, 1)
        return self.neutral + moved

    def _row(self, weights: Mapping[str, float]) -> NDArray[np.float64]:
        return np.array([weights.get(name, 0.0) for name in self.names])


def originals_of(character: Character, model: CompressedTextures, path: Path) -> Originals:
    """The originals of a pack's blends.

    A character that has the pack's expressions gives their textures. For a rigged pack whose scans the character is,
    they are the naive sum, B⁺ of the example weights in ``rig.json`` beside the pack: no scan shows a shape alone.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``, or ``UNKNOWN_NAME`` where the pack belongs to other scans.
    """
    check_sizes(character, model, path)
    warn_of_another(character, model, path)
    missing = [name for name in model.expressions if name not in character.expressions]
    if missing:
        return _naive(character, model, path, missing[0])
    order = [character.index(name) for name in model.expressions]
    return Originals(
        character,
        model.expressions,
        np.eye(len(character.expressions))[order],
        character.meshes.neutral,
        character.meshes.deltas[order],
        "the sum of the uncompressed textures' differences (equation 8)",
    )


def _naive(character: Character, model: CompressedTextures, path: Path, missing: str) -> Originals:
    scans = _example_weights(path.parent / RIG)
    if model.meshes is None or [*scans] != [*character.expressions]:
        reason = f"has no expression of {character.name} for '{missing}', and no {RIG} of its scans beside it"
        raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"{path}: {reason}; give the character that it was made from")
    weights = np.array([[row.get(name, 0.0) for name in model.expressions] for row in scans.values()], np.float64)
    return Originals(
        character,
        model.expressions,
        Examples.of(weights).inverse,
        model.meshes.neutral,
        model.meshes.deltas,
        "the naive sum of the scans' differences (B⁺ of the rig): no scan shows a shape alone, so that a difference is "
        "the rig's as well as the compression's, and that sum exaggerates the noise of scans",
    )


def _example_weights(document: Path) -> dict[str, dict[str, float]]:
    """By scan, how much of each shape is in it; nothing where there is no rig."""
    if not document.is_file():
        return {}
    try:
        scans = {
            str(scan): {str(shape): float(weight) for shape, weight in row.items()}
            for scan, row in json.loads(document.read_text(encoding="utf-8"))["example_weights"].items()
        }
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        reason = "not the record of a rig; run 'facezip rig' again"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{document}: {reason}") from None
    if not all(math.isfinite(weight) for row in scans.values() for weight in row.values()):
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{document}: a weight is not a finite number; run 'facezip rig' again")
    return scans
