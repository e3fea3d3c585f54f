"""Expressions x views x lights x packs: render what is missing, and gather everything in one document."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from facezip.character import NEUTRAL, Character, check_names
from facezip.progress import task
from render.flip import PIXELS_PER_DEGREE
from render.llvm import start
from render.metrics import UNITS
from render.paired import Images
from render.settings import Settings
from render.shots import Shot, Studio, looks, repeat_of
from render.skins import SkinMaps, Texture, uploaded
from render.store import RENDERS, ShotStore, digest_of
from render.summary import summarise

FORMAT = "facezip-validation/1"


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is judged.

    Attributes
    ----------
    name : of the pack or character.
    texture : gives ``(H, W, C)`` float32 in [0, 1], encoded, for an expression or ``"neutral"``; or all maps of a skin.
    facts : ``method``, ``bytes_on_gpu``, ``bytes_on_disk``, ``bytes_raw``, ``fetches``, ``texture_rmse`` and
        ``texture_rmse_per_expression``.
    """

    name: str
    texture: Callable[[str], Texture]
    facts: dict[str, Any]


def validate(
    character: Character,
    candidates: list[Candidate],
    folder: Path,
    settings: Settings | None = None,
    earlier: Path | None = None,
    original: Callable[[str], Texture] | None = None,
) -> dict[str, Any]:
    """Render the character with its own and each candidate's textures, and measure every difference.

    Writes ``folder/renders/EXPRESSION.VIEW.LIGHT.exr``, a part ``original`` and one a candidate, and its measurements
    beside it. Shots found there, or in the report ``earlier``, are not rendered again if nothing that made them
    changed. ``original`` gives the character's own textures, where they are more than its albedo; every candidate's
    are then of the same kind.

    Returns
    -------
    The document of the report: character, conditions, packs with means and worst renders, every render, timings.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for settings outside their range, ``UNSAFE_NAME``, ``NO_LLVM``, ``CANNOT_WRITE``.
    """
    settings = settings or Settings()
    settings.check()
    check_names(character.expressions, character.name)
    begin = perf_counter()
    conditions = _conditions(character, settings, start())
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        store = ShotStore(folder, earlier)
        run = _Run(character, original or character.texture, candidates, settings, store, conditions, pool)
        renders, floors = run.renders(), run.floors()
        run.finish()
    for render in renders:
        render["noise_floor"] = floors[render["view"], render["light"]] | render["noise_floor"]
    total = perf_counter() - begin
    return {
        "format": FORMAT,
        "character": character.facts,
        "conditions": conditions,
        "packs": [
            summarise(k, candidate.name, candidate.facts, renders, settings.thresholds)
            for k, candidate in enumerate(candidates)
        ],
        "renders": renders,
        "rendered": run.rendered,
        "seconds": {name: round(value, 2) for name, value in {**run.seconds, "total": total}.items()},
        "pairs_per_second": round(run.rendered * len(candidates) / total, 2),
    }


class _Run:
    """One call of :func:`validate`: what there is to render, and what is done."""

    def __init__(
        self,
        character: Character,
        original: Callable[[str], Texture],
        candidates: list[Candidate],
        settings: Settings,
        store: ShotStore,
        conditions: dict[str, Any],
        pool: ThreadPoolExecutor,
    ) -> None:
        self.rendered, self.seconds = 0, {"render": 0.0, "metrics": 0.0}
        self._character, self._candidates, self._settings = character, candidates, settings
        self._original = original
        self._store, self._conditions, self._pool = store, conditions, pool
        self._studio: Studio | None = None
        self._writing: list[Future[None]] = []

    def renders(self) -> list[dict[str, Any]]:
        names, views = (NEUTRAL, *self._character.expressions), list(looks(self._settings))
        with task("Rendering", len(names) * len(views)) as advance:
            found = []
            for name in names:
                textures = [self._original(name), *(candidate.texture(name) for candidate in self._candidates)]
                for measured in self._shots([Shot(name, *look) for look in views], textures):
                    found.append(measured)
                    advance()
        return found

    def floors(self) -> dict[tuple[str, str], dict[str, Any]]:
        """By view and light: every metric of the original neutral against itself with other random numbers."""
        textures = [self._original(NEUTRAL)]
        inputs, posed, floors = self._inputs(NEUTRAL, textures), None, {}
        for shot in (repeat_of(*look) for look in looks(self._settings)):
            name, digest = f"{shot.view.name}.{shot.light}.floor", self._digest(shot, inputs)
            floor = self._store.find(name, digest)
            if floor is None:
                posed = posed or self._posed(shot.expression, textures)
                floor = posed[0].floor(shot, posed[1])
                self._store.keep(name, digest, floor, {}, {})
            floors[shot.view.name, shot.light] = floor
        return floors

    def finish(self) -> None:
        """Wait until everything is on disk."""
        for future in self._writing:
            future.result()
        self._store.prune()
        if self._studio:
            self.seconds = self._studio.seconds

    def _shots(self, shots: list[Shot], textures: list[Texture]) -> Iterator[dict[str, Any]]:
        inputs, posed = self._inputs(shots[0].expression, textures), None
        for shot in shots:
            digest = self._digest(shot, inputs)
            measured = self._store.find(shot.name, digest)
            if measured is None:
                posed = posed or self._posed(shot.expression, textures)
                measured, images = posed[0].take(shot, posed[1])
                measured = {**measured, "exr": f"{RENDERS}/{shot.name}.exr"}
                self._keep(shot, digest, measured, images)
                self.rendered += 1
            yield measured

    def _posed(self, name: str, textures: list[Texture]) -> tuple[Studio, list[Any]]:
        if self._studio is None:
            self._studio = Studio(self._character, self._settings, self._pool)
        self._studio.pose(self._character.mesh_vertices(name))
        return self._studio, [uploaded(texture, self._settings.material) for texture in textures]

    def _inputs(self, name: str, textures: list[Texture]) -> str:
        topology, character = self._character.topology, self._character
        meshes = character.neutral_vertices, character.mesh_vertices(name)
        arrays = [part for one in textures for part in (one.arrays if isinstance(one, SkinMaps) else (one,))]
        return digest_of({}, (topology.faces, topology.uv, topology.face_uv, *meshes, *arrays))

    def _digest(self, shot: Shot, inputs: str) -> str:
        # Other views, lights and expressions do not change this one.
        settings = {key: value for key, value in self._conditions.items() if key not in ("views", "lights")}
        look = {"view": vars(shot.view), "light": shot.light, "names": [one.name for one in self._candidates]}
        return digest_of({"format": FORMAT, "inputs": inputs, **settings, **look}, ())

    def _keep(self, shot: Shot, digest: str, measured: dict[str, Any], images: Images) -> None:
        names = ["original", *(f"{k + 1} {candidate.name}" for k, candidate in enumerate(self._candidates))]
        alpha = images.coverage[:, :, None]
        parts = {
            name: np.concatenate([linear, alpha], axis=2) for name, linear in zip(names, images.linear, strict=True)
        }
        facts = {"view": shot.view.name, "light": shot.light, "spp": str(measured["spp"])}
        facts |= {key: str(self._conditions[key]) for key in ("seed", "material", "transport")}
        self._writing.append(self._pool.submit(self._store.keep, shot.name, digest, measured, parts, facts))
        if len(self._writing) > 4:
            # Rendering must not run ahead of writing: every pending shot holds its images.
            self._writing[-5].result()


def _conditions(character: Character, settings: Settings, versions: dict[str, str]) -> dict[str, Any]:
    return {
        **versions,
        **settings.resolved,
        "sampler": "multijitter, two independent halves",
        "pixels_per_degree": PIXELS_PER_DEGREE,
        "display": "linear radiance clipped to 0..1, sRGB-encoded",
        "region": "pixels that the head fills at least half",
        "texture_region": "whole texture" if character.mask is None else "the character's mask",
        "confidence": "95 %, from two halves, free of the bias of noise to first order",
        "units": UNITS,
    }
