"""Importance of a character's texels for some views, and a fit with it beside a uniform one at equal bytes."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.importance import map_factors
from facezip.fit.methods import compress
from facezip.fit.settings import Settings
from facezip.pack.errors import model_errors
from facezip.pack.model import CompressedTextures
from render.candidates import texels_of
from render.documents.conditions import Versions
from render.effect import image_errors
from render.importance import Look, Sight, face_means, regularised, seen_importance
from render.llvm import start
from render.staging import rendered_maps, staged
from reports.importance.documents import (
    Change,
    FitFacts,
    FitSettings,
    ImportanceConditions,
    ImportanceDocument,
    ImportanceFacts,
    ImportanceSeconds,
    LookErrors,
    Pair,
)
from scenes.cameras import VIEWS
from scenes.lights import RIGS

FITS = ("uniform", "importance")
# What weights are exact for, how others are found, and what has none.
LINEAR = "the albedo, exact, as direct light is linear in it"
SLOPES = "by finite differences, exact for small errors"
WITHOUT = "the albedo's, as they do not show in the light"
# The images that judge take other random numbers than those that the importance was made from.
JUDGING_SEED = 2**20


def looks_of(views: int, lights: int) -> tuple[tuple[Look, ...], tuple[Look, ...]]:
    """The looks of the first ``views`` views under the first ``lights`` rigs, and those of all other views."""
    rigs = list(RIGS)[:lights]
    return tuple(product(VIEWS[:views], rigs)), tuple(product(VIEWS[views:], rigs))


def measure_importance(
    character: Character, sight: Sight, held_out: Sequence[Look], fit: FitSettings, floor: float
) -> tuple[ImportanceDocument, dict[Key, NDArray[np.float32]]]:
    """Make the importance for ``sight``, fit with and without it, and judge both by images of all maps.

    Parameters
    ----------
    character : at least two expressions, with any maps and tiles.
    sight : the looks that the importance is made for.
    held_out : looks that it knows nothing of.
    fit : settings of the refined fit, the same for both.
    floor : of :func:`render.importance.regularised`.

    Returns
    -------
    document : what was measured.
    importance : by map and tile, ``(H, W)`` float32 ≥ 0, what ``facezip compress --importance`` takes.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE``: no camera sees the face region, or a setting of the fit is outside its range.
    """
    Settings(**vars(fit)).check("refined")
    begin = perf_counter()
    versions = start()
    seen = seen_importance(character, sight)
    inside = {key: character.stacks[key].weight for key in seen}
    if not face_means(seen, inside)[ALBEDO]:
        reason = "no camera sees a texel of the face region; check mask, UVs and that the face looks to +z"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{character.name}: {reason}")
    importance = regularised(seen, inside, floor)
    made = perf_counter()
    models = [compress(character, **vars(fit)), compress(character, **vars(fit), importance=importance)]
    fitted = perf_counter()
    every = replace(sight, looks=(*sight.looks, *held_out), seed=sight.seed + JUDGING_SEED)
    errors = image_errors(character, [staged(character, texels_of(model)) for model in models], every)
    looks = _looks(every.looks, errors, len(sight.looks))
    document = ImportanceDocument(
        character=character.facts,
        conditions=_conditions(character, sight, held_out, fit, versions, _words(character, importance)),
        importance=_facts(character, seen, importance, inside, floor),
        fits=[_fit(*each) for each in zip(FITS, models, [character] * 2, strict=True)],
        looks=looks,
        change=_change(looks),
        seconds=ImportanceSeconds(
            importance=round(made - begin, 1),
            fits=round(fitted - made, 1),
            total=round(perf_counter() - begin, 1),
        ),
    )
    return document, importance


def _facts(
    character: Character,
    seen: Mapping[Key, NDArray[np.float32]],
    importance: Mapping[Key, NDArray[np.float32]],
    inside: Mapping[Key, NDArray[np.float32]],
    floor: float,
) -> ImportanceFacts:
    """Of the albedo on all tiles."""
    keys = [key for key in seen if key[0] == ALBEDO]
    looked_at = sum(((seen[key] > 0) * inside[key]).sum(dtype=np.float64) for key in keys)
    on_face = np.concatenate([importance[key][inside[key] > 0] for key in keys])
    return ImportanceFacts(
        floor=floor,
        seen_share=float(looked_at / sum(inside[key].sum(dtype=np.float64) for key in keys)),
        largest=float(max(importance[key].max() for key in keys)),
        p99=float(np.percentile(on_face, 99)),
        counts=_counts(character, seen, inside),
    )


def _counts(
    character: Character, seen: Mapping[Key, NDArray[np.float32]], inside: Mapping[Key, NDArray[np.float32]]
) -> dict[str, float]:
    """How much each map counts beside the albedo, in parts of what it does without an importance."""
    means, alike = face_means(seen, inside), map_factors(character, {})
    return {name: mean / means[ALBEDO] / alike[name] for name, mean in means.items() if mean > 0}


def _fit(name: str, model: CompressedTextures, character: Character) -> FitFacts:
    cost, errors = model.footprint, model_errors(character, model)
    return FitFacts(
        name=name,
        texture_rmse=errors[ALBEDO].mean,
        map_errors=errors,
        bytes_on_gpu=cost.bytes_on_gpu,
        fetches=cost.fetches,
    )


def _looks(looks: Sequence[Look], errors: NDArray[np.float64], made_for: int) -> list[LookErrors]:
    """Root mean square over expressions of the image errors of both fits, look by look."""
    pooled = np.sqrt(np.square(errors).mean(axis=1))
    return [
        LookErrors(**vars(_pair(*pooled[:, i].tolist())), view=view.name, light=rig, held_out=i >= made_for)
        for i, (view, rig) in enumerate(looks)
    ]


def _change(looks: Sequence[LookErrors]) -> Change:
    """Image errors of both fits, pooled over the looks they were made for and over the held-out ones."""
    made_for, worst_made_for = _pooled([look for look in looks if not look.held_out])
    held_out, worst_held_out = _pooled([look for look in looks if look.held_out])
    return Change(made_for=made_for, worst_made_for=worst_made_for, held_out=held_out, worst_held_out=worst_held_out)


def _pooled(looks: Sequence[LookErrors]) -> tuple[Pair | None, float | None]:
    if not looks:
        return None, None
    pooled = [float(np.sqrt(np.mean([getattr(look, fit) ** 2 for look in looks]))) for fit in FITS]
    return _pair(*pooled), max(look.change for look in looks)


def _pair(uniform: float, importance: float) -> Pair:
    return Pair(uniform=uniform, importance=importance, change=importance / uniform - 1 if uniform else 0.0)


def _conditions(
    character: Character,
    sight: Sight,
    held_out: Sequence[Look],
    fit: FitSettings,
    versions: Versions,
    found: Sequence[str],
) -> ImportanceConditions:
    return ImportanceConditions(
        **vars(versions),
        spp=sight.spp,
        sampler="multijitter",
        seed=sight.seed,
        judging_seed=sight.seed + JUDGING_SEED,
        light_transport="direct",
        skin=sight.material,
        resolution=sight.resolution,
        views=list(dict.fromkeys(view.name for view, _ in sight.looks)),
        held_out_views=list(dict.fromkeys(view.name for view, _ in held_out)),
        lights=list(dict.fromkeys(rig for _, rig in sight.looks)),
        expressions="all, without the neutral, which a pack holds exactly",
        errors="image RMSE 0..255, encoded sRGB, over head pixels; root mean square over expressions",
        texture_region="the character's mask" if character.masked else "whole texture",
        maps_rendered=rendered_maps(character),
        importance_of="; ".join(found),
        **vars(fit),
    )


def _words(character: Character, importance: Mapping[Key, NDArray[np.float32]]) -> list[str]:
    """How the importance of each map was found."""
    met = [name for name in dict.fromkeys(name for name, _ in importance) if name != ALBEDO]
    unmet = [kind.name for kind in character.maps if kind.name not in (ALBEDO, *met)]
    found = [(met, SLOPES), (unmet, WITHOUT)]
    return [LINEAR, *(f"{', '.join(names)}: {words}" for names, words in found if names)]
