"""How far textures are from the scans: RMSE of colours and data, degrees of normals, over all tiles of a map."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key, Map, angles
from facezip.character.scans import Character, Stack
from facezip.files.images import Texels, to_float
from facezip.files.reading import undisturbed
from facezip.machine.progress import track
from facezip.machine.rows import sum_rows
from facezip.pack.measure import encoded, model_squares, texels_seen, texture_square
from facezip.pack.model import CompressedTextures, Part, blended_rows
from facezip.pack.quantise import StoredTextures, dequantise_part
from facezip.pack.read import read_stored
from facezip.pack.verification import verify_pack

Rows = Callable[[slice], NDArray[np.float32]]


@dataclass(frozen=True, kw_only=True)
class MapErrors:
    """How far one map is from the scans, over all tiles, inside the mask; means over expressions.

    Of colours and data ``rmse``, of normals ``angular_error``.

    Attributes
    ----------
    rmse : 0..255, of a map's range where it has one.
    rmse_per_expression : the same by expression.
    angular_error : mean angle in degrees.
    angular_error_rms : its root mean square.
    angular_error_per_expression : the mean angle by expression.
    """

    rmse: float | None = None
    rmse_per_expression: Mapping[str, float] | None = None
    angular_error: float | None = None
    angular_error_rms: float | None = None
    angular_error_per_expression: Mapping[str, float] | None = None

    @property
    def is_angular(self) -> bool:
        """Whether they are of normals."""
        return self.angular_error is not None

    @property
    def mean(self) -> float:
        """The error in the map's own unit: degrees of normals, else parts of 255."""
        return next(error for error in (self.angular_error, self.rmse) if error is not None)

    @property
    def means(self) -> "MapErrors":
        """The same without numbers of single expressions."""
        return replace(self, rmse_per_expression=None, angular_error_per_expression=None)

    @property
    def per_expression(self) -> Mapping[str, float]:
        """:attr:`mean` by expression; empty where that was not kept."""
        return self.angular_error_per_expression or self.rmse_per_expression or {}


# By map.
Errors = dict[str, MapErrors]


def model_errors(character: Character, model: CompressedTextures | StoredTextures) -> Errors:
    """For each map of a character, the errors of ``model.reconstruct`` over all its tiles, inside the mask."""
    return {kind.name: _of_map(character, kind, _ModelSide(character, model, kind)) for kind in character.maps}


def pack_errors(character: Character, path: str | Path) -> Errors:
    """:func:`model_errors` of a pack, which is verified first; what can stay the bytes that they are stays so.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` raises.
    """
    folder = Path(path)
    return model_errors(character, undisturbed(folder, lambda: read_stored(folder, verify_pack(folder))))


def texture_errors(character: Character, texels: Callable[[str, Key], Texels]) -> Errors:
    """:func:`model_errors` of any textures: ``texels`` gives ``(H, W, C)`` of an expression's map on a tile."""
    return {kind.name: _of_map(character, kind, _TextureSide(character, texels, kind)) for kind in character.maps}


def albedo_errors(character: Character, model: CompressedTextures | StoredTextures) -> Mapping[str, float]:
    """RMSE of every expression's albedo (0..255) over all tiles, inside the mask."""
    return rmse_per_expression(model_errors(character.only(ALBEDO), model))


def rmse_per_expression(errors: Errors) -> Mapping[str, float]:
    """Of the albedo."""
    return errors[ALBEDO].per_expression


def mean_rmse(errors: Mapping[str, float]) -> float:
    """The mean over expressions of their RMSE: one number for a character, as in the paper's Figure 6."""
    return sum(errors.values()) / len(errors)


class _ModelSide:
    """One map of a model, against the scans."""

    def __init__(self, character: Character, model: CompressedTextures | StoredTextures, kind: Map) -> None:
        self._model, self._kind = model, kind
        self._order = [model.expressions.index(name) for name in character.expressions]
        # Of one tile at a time, for all its expressions.
        self._parts: dict[int, Part] = {}
        self._maps: dict[int, NDArray[np.float32]] = {}

    def squares(self, stack: Stack, tile: int) -> NDArray[np.float64]:
        part = self._model.parts[self._kind.name, tile]
        return model_squares(stack, encoded(part), self._weights(tile), self._order)

    def rows_of(self, n: int, tile: int) -> Rows:
        return blended_rows(self._part(tile), self._weights(tile)[self._order[n]])

    def _weights(self, tile: int) -> NDArray[np.float32]:
        if tile not in self._maps:
            weights = self._model.weights[tile]
            self._maps = {tile: weights if isinstance(weights, np.ndarray) else weights.values}
        return self._maps[tile]

    def _part(self, tile: int) -> Part:
        if tile not in self._parts:
            part = self._model.parts[self._kind.name, tile]
            self._parts = {tile: part if isinstance(part, Part) else dequantise_part(part, self._kind)}
        return self._parts[tile]


class _TextureSide:
    """One map of any textures, against the scans."""

    def __init__(self, character: Character, texels: Callable[[str, Key], Texels], kind: Map) -> None:
        self._names, self._texels, self._map = character.expressions, texels, kind.name

    def squares(self, stack: Stack, tile: int) -> NDArray[np.float64]:
        names = track(self._names, "Measuring textures", len(self._names))
        theirs = (to_float(self._texels(name, (self._map, tile))) for name in names)
        return np.array([texture_square(stack, n, texels) for n, texels in enumerate(theirs)])

    def rows_of(self, n: int, tile: int) -> Rows:
        texels = self._texels(self._names[n], (self._map, tile))
        return lambda rows: to_float(texels[rows])


def _of_map(character: Character, kind: Map, side: _ModelSide | _TextureSide) -> MapErrors:
    # A tile whose mask shows nothing of the face has no error.
    seen = {tile: texels for tile, stack in character.of_map(kind.name).items() if (texels := texels_seen(stack)) > 0}
    return (_angular if kind.is_normal else _rmse)(character, kind, side, seen)


def _rmse(character: Character, kind: Map, side: _ModelSide | _TextureSide, seen: Mapping[int, float]) -> MapErrors:
    stacks = {tile: character.stacks[kind.name, tile] for tile in seen}
    squares = np.sum([side.squares(stack, tile) for tile, stack in stacks.items()], axis=0)
    values = sum(seen[tile] * stack.channels for tile, stack in stacks.items())
    per_expression = dict(zip(character.expressions, (255 * np.sqrt(squares / values)).tolist(), strict=True))
    return MapErrors(rmse=mean_rmse(per_expression), rmse_per_expression=per_expression)


def _angular(character: Character, kind: Map, side: _ModelSide | _TextureSide, seen: Mapping[int, float]) -> MapErrors:
    names = character.expressions
    total = np.zeros((len(names), 2))
    for tile in seen:
        stack = character.stacks[kind.name, tile]
        weight = stack.weight
        for n, _ in enumerate(track(names, "Measuring normals", len(names))):
            total[n] += _moments(kind, stack.textures[n], weight, side.rows_of(n, tile))
    mean, square = total.T / sum(seen.values())
    per_expression = dict(zip(names, mean.tolist(), strict=True))
    return MapErrors(
        angular_error=mean_rmse(per_expression),
        angular_error_rms=float(np.sqrt(square).mean()),
        angular_error_per_expression=per_expression,
    )


def _moments(kind: Map, original: Texels, weight: NDArray[np.float32], theirs: Rows) -> NDArray[np.float64]:
    """The sums over texels of angles in degrees, and of their squares."""

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        rows = slice(top, bottom)
        degrees = angles(kind.decode(original[rows]), kind.decode(theirs(rows)))
        weighted = weight[rows] * degrees
        return np.array([weighted.sum(dtype=np.float64), (weighted * degrees).sum(dtype=np.float64)])

    return sum_rows(block, len(original))
