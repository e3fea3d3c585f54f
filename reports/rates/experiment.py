"""Everything that is tried, on one character and on the same with blends added, as one document."""

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.supercompression import LEVEL
from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.conditions import conditions
from facezip.machine.progress import track
from reports.rates.comparison import compare
from reports.rates.documents import RatesConditions, RatesDocument, Round, Seconds
from reports.rates.families import tried

BLENDED = 3
LIBRARIES = ("facezip", "numpy", "numba", "astc-encoder-py", "etcpak", "texture2ddecoder", "zstandard")


def measure_rates(character: Character, total: int, effort: str, seed: int) -> RatesDocument:
    """Error against bytes of everything that :func:`reports.rates.families.tried` names.

    Parameters
    ----------
    character : at least two expressions; all maps on all tiles are measured.
    total : a second round has so many expressions, blends of the others added; 0 for one round.
    effort : of the ASTC encoder, for all alike: ``"fast"``, ``"medium"`` or ``"thorough"``.
    seed : of the blends.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a ``total`` that adds nothing.
    """
    begin = perf_counter()
    # Before any work: it refuses a total that adds nothing.
    larger = [with_blends(character, total, seed)] if total else []
    rounds = [_round(one, effort) for one in (character, *larger)]
    return RatesDocument(
        character=character.facts,
        conditions=RatesConditions(
            **vars(conditions(LIBRARIES)),
            errors="RMSE 0..255 of what the decoders give back, mean over expressions; over several maps the root "
            "of the mean of their squares, normals as images (n + 1) / 2",
            texture_region="the character's mask" if character.masked else "whole texture",
            bytes="GPU memory of neutral, differences or expressions, and weight maps, of all maps and tiles, "
            "without mip-maps; a texel is one of any map",
            files=f"the same as files: blocks in KTX2 under Zstandard at level {LEVEL}, raw texels in PNG",
            textures="each map has textures of its own, all in the same codec; of normals x and y are coded",
            astc_effort=effort,
            bc="BC1 and BC7 by etcpak, BC7 at its highest level; with the slowest encoders that are known, a texture "
            "has 33 to 56 % less error in BC1 and 6 to 13 % less in BC7 (docs/comparison.md)",
            seed=seed,
        ),
        rounds=rounds,
        seconds=Seconds(total=round(perf_counter() - begin, 1)),
    )


def with_blends(character: Character, total: int, seed: int) -> Character:
    """``total`` expressions: the character's own, and convex mixtures of three of them each, rounded like the others.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` where there are as many already, or fewer than three to mix.
    """
    count = len(character.expressions)
    if not BLENDED <= count < total:
        reason = f"{count} expressions; blends of three make more than that of at least three, choose another total"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{character.name}: {reason} than {total}")
    rng = np.random.default_rng(seed)
    shares = np.zeros((total - count, count), np.float32)
    for row in shares:
        row[rng.choice(count, BLENDED, replace=False)] = rng.dirichlet(np.ones(BLENDED))
    meshes = character.meshes
    vertices = np.concatenate([meshes.vertices, np.tensordot(shares, meshes.vertices, axes=1)])
    return replace(
        character,
        expressions=(*character.expressions, *(f"blend_{number}" for number in range(total - count))),
        meshes=replace(meshes, vertices=vertices),
        stacks={key: _blended(stack, shares) for key, stack in character.stacks.items()},
    )


def _blended(stack: Stack, shares: NDArray[np.float32]) -> Stack:
    """The textures, and behind them mixtures ``shares`` ``(K, N)`` of them."""
    count = len(stack.textures)
    textures = np.empty((count + len(shares), *stack.textures.shape[1:]), stack.textures.dtype)
    textures[:count] = stack.textures
    for texture, row in zip(textures[count:], shares, strict=True):
        mixture = np.tensordot(row, stack.textures.astype(np.float32), axes=1)
        texture[:] = np.rint(mixture) if textures.dtype.kind == "u" else mixture
    return replace(stack, textures=textures)


def _round(character: Character, effort: str) -> Round:
    ways = tried(character, effort)
    count = len(character.expressions)
    points = [way.measure(character) for way in track(ways, f"{count} expressions", len(ways))]
    return Round(expressions=count, points=points, comparison=compare(points))
