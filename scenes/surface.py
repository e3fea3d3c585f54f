"""The embedded character with all its maps, and on several UDIM tiles."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Key, normals_of
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.machine.progress import track
from scenes.character import Person, Posed, captures, check_size, scanned
from scenes.face.capture import Nuisances, captured
from scenes.face.expressions import expression_weights

# What there is besides the albedo, in the order of files.
MAPS = ("normal", "roughness", "specular", "cavity")


def make_surface(
    resolution: int = 512,
    expressions: int = 20,
    seed: int = 0,
    nuisances: float = 1.0,
    tiles: tuple[int, int] = (1, 1),
    maps: tuple[str, ...] = MAPS[:2],
) -> Character:
    """Scans of the embedded character with several maps of 8 bits, misregistered alike.

    Parameters
    ----------
    resolution, expressions, seed, nuisances : as of :func:`scenes.character.make_character`, whose albedo this is.
    tiles : columns and rows of UDIM tiles that its chart is spread over, at most 10 columns; both divide
        ``resolution``.
    maps : names out of :data:`MAPS`, besides the albedo; none depends on which others there are.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a size or number outside its range, or a map that the character does not have.
    """
    check_size(resolution, expressions)
    for name in maps:
        if name not in MAPS:
            reason = f"has no map '{name}'; it has {', '.join((ALBEDO, *MAPS))}"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"the embedded character {reason}")
    person = Person.make(resolution, seed)
    named = expression_weights(expressions, seed)
    # Maps are solved for from photographs under many lights: exposure does not count, and noise averages out.
    strengths = Nuisances().scaled(nuisances)
    steady = replace(strengths, drift=0.0, noise=0.5 * strengths.noise)
    stacks: dict[str, list[Texels]] = {name: [] for name in (ALBEDO, *MAPS) if name in (ALBEDO, *maps)}
    scans = captures(person, named, nuisances)
    for albedo, posed, rng in track(scans, "Making the maps", 1 + len(named)):
        found = {ALBEDO: albedo, **_further(posed, steady, rng)}
        for name, stack in stacks.items():
            stack.append(found[name])
    stacked: dict[str, tuple[Any, Any]] = {name: (stack[0], np.stack(stack[1:])) for name, stack in stacks.items()}
    return in_tiles(scanned(person, named, stacked), *tiles)


def _further(posed: Posed, nuisances: Nuisances, rng: np.random.Generator) -> dict[str, Texels]:
    """All of :data:`MAPS` as a capture gives them, 8 bits a channel; normals as the slopes of those are fitted."""
    truth = posed.relief
    encoded = np.concatenate(
        [(normals_of(truth.slopes) + 1) / 2, truth.roughness, truth.specular, truth.cavity], axis=2
    )
    seen = np.rint(captured(encoded, nuisances, rng, registered=not posed.weights) * 255)
    normals = KNOWN["normal"].encode(_unit(2 * seen[..., :3] / 255 - 1))
    found: dict[str, Texels] = {"normal": np.rint(normals * 65535).astype(np.uint16)}
    for channel, name in enumerate(MAPS[1:], 3):
        found[name] = np.ascontiguousarray(seen[..., channel, None]).astype(np.uint8)
    return found


def in_tiles(character: Character, columns: int, rows: int) -> Character:
    """A character of one tile, its chart cut into a grid of UDIM tiles, each with its part of the texels."""
    if (columns, rows) == (1, 1):
        return character
    layout = character.meshes.topology
    topology = replace(layout, uv=layout.uv * np.array([columns, rows], np.float32))
    stacks: dict[Key, Stack] = {}
    for row in range(rows):
        for column in range(columns):
            tile = FIRST_TILE + column + 10 * row
            stacks |= {
                (name, tile): _cut(stack, column, row, columns, rows) for (name, _), stack in character.stacks.items()
            }
    return replace(character, meshes=replace(character.meshes, topology=topology), stacks=stacks)


def _cut(stack: Stack, column: int, row: int, columns: int, rows: int) -> Stack:
    height, width = stack.resolution[0] // rows, stack.resolution[1] // columns
    # Row 0 of a texture is its top, tiles count from below.
    down, across = slice((rows - 1 - row) * height, (rows - row) * height), slice(column * width, (column + 1) * width)
    mask = None if stack.mask is None else stack.mask[down, across]
    return Stack(stack.neutral[down, across], stack.textures[:, down, across], mask)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float32]:
    length = np.sqrt(np.square(vectors).sum(axis=2, keepdims=True))
    return (vectors / np.maximum(length, 1e-6)).astype(np.float32)
