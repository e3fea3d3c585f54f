"""Expressions x views x lights x packs: render what is missing, and gather everything in one document."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import Self

import numpy as np

from facezip.character.scans import NEUTRAL, Character, check_names
from facezip.documents.document import plain
from facezip.machine.cores import cores
from facezip.machine.progress import task
from facezip.pack.errors import Errors
from facezip.pack.facts import PackFacts
from render.documents.conditions import RenderSeconds, Versions
from render.documents.images import ImageMetrics, Render, Taken
from render.documents.judged import TextureFacts
from render.documents.validation import ValidationConditions, ValidationDocument
from render.flip import PIXELS_PER_DEGREE
from render.limits import DECIDING
from render.llvm import start
from render.metrics import UNITS
from render.paired import Images
from render.points import REVISION
from render.presence import face_triangles
from render.scattering import spread
from render.settings import Settings
from render.shots import Shot, Studio, looks, repeat_of
from render.skins import Skin, SkinMaps, upload
from render.staging import staged_original, staged_topology
from render.store import ShotStore, digest_of
from render.summary import summarise


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is judged.

    Attributes
    ----------
    name : of the pack or character.
    texture : gives the maps of a skin for an expression or ``"neutral"``.
    facts : what it costs.
    errors : of its textures, by map.
    """

    name: str
    texture: Callable[[str], SkinMaps]
    facts: PackFacts | TextureFacts
    errors: Errors


@dataclass(frozen=True)
class Filled:
    """What one worker did for one expression: shots rendered, and seconds of rendering and of measuring them."""

    rendered: int
    seconds: dict[str, float]


class Filler:
    """One worker's part of a validation: it renders and measures into the store that :func:`validate` reads.

    A context manager: its threads end with it.

    Parameters
    ----------
    character, candidates, folder, settings, earlier : as of :func:`validate`.
    """

    def __init__(
        self,
        character: Character,
        candidates: list[Candidate],
        folder: Path,
        settings: Settings,
        earlier: Path | None = None,
    ) -> None:
        self._pool, store = ThreadPoolExecutor(cores()), ShotStore(folder, earlier)
        conditions = _conditions(character, settings, start())
        self._run = _Run(character, candidates, settings, store, conditions, self._pool)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()

    def fill(self, name: str) -> Filled:
        """Every shot of an expression that is missing; with those of the neutral, the noise floors."""
        rendered, before = self._run.rendered, dict(self._run.seconds)
        for _ in self._run.expression(name):
            pass
        if name == NEUTRAL:
            self._run.floors()
        self._run.settle()
        spent = {part: seconds - before[part] for part, seconds in self._run.seconds.items()}
        return Filled(self._run.rendered - rendered, spent)


def validate(
    character: Character,
    candidates: list[Candidate],
    folder: Path,
    settings: Settings | None = None,
    earlier: Path | None = None,
    distribute: Callable[[Sequence[str]], Iterable[Filled]] = lambda _: (),
) -> ValidationDocument:
    """Render the character with its own and each candidate's textures, and measure every difference.

    Writes ``folder/renders/EXPRESSION.VIEW.LIGHT.exr``, a part ``original`` and one a candidate, and its measurements
    beside it. Shots found there, or in the report ``earlier``, are not rendered again if nothing that made them
    changed. ``distribute`` is given all names, the neutral's too, and may have any of them filled by a :class:`Filler`
    elsewhere; what it leaves is rendered here.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for settings outside their range, ``UNSAFE_NAME``, ``NO_LLVM``, ``CANNOT_WRITE``,
        ``NOTHING_TO_SEE`` for a picture without a face.
    """
    settings = settings or Settings()
    settings.check()
    check_names(character.expressions, character.name)
    begin = perf_counter()
    conditions = _conditions(character, settings, start())
    with ThreadPoolExecutor(cores()) as pool:
        elsewhere = list(distribute((NEUTRAL, *character.expressions)))
        store = ShotStore(folder, earlier)
        run = _Run(character, candidates, settings, store, conditions, pool)
        shots, floors = run.shots(), run.floors()
        run.finish()
    filled = [Filled(run.rendered, run.seconds), *elsewhere]
    rendered = sum(part.rendered for part in filled)
    seconds = {name: sum(part.seconds[name] for part in filled) for name in run.seconds}
    renders = [_with_floor(shot, floors[shot.view, shot.light]) for shot in shots]
    total = perf_counter() - begin
    return ValidationDocument(
        character=character.facts,
        conditions=conditions,
        packs=[
            summarise(k, candidate.name, candidate.facts, candidate.errors, renders, settings.thresholds)
            for k, candidate in enumerate(candidates)
        ],
        renders=renders,
        rendered=rendered,
        seconds=RenderSeconds(**{name: round(value, 2) for name, value in {**seconds, "total": total}.items()}),
        pairs_per_second=round(rendered * len(candidates) / total, 2),
    )


def _with_floor(shot: Taken, floor: ImageMetrics) -> Render:
    """The shot with the noise floor of its look, but for the image RMSE, of which it has its own."""
    return Render(**{**vars(shot), "noise_floor": replace(floor, image_rmse=shot.noise_floor.image_rmse)})


class _Run:
    """One call of :func:`validate`: what there is to render, and what is done."""

    def __init__(
        self,
        character: Character,
        candidates: list[Candidate],
        settings: Settings,
        store: ShotStore,
        conditions: ValidationConditions,
        pool: ThreadPoolExecutor,
    ) -> None:
        self.rendered = 0
        self._character, self._candidates, self._settings = character, candidates, settings
        self._topology, self._original = staged_topology(character), staged_original(character)
        self._store, self._conditions, self._pool = store, conditions, pool
        self._studio: Studio | None = None
        self._writing: list[Future[None]] = []

    @property
    def seconds(self) -> dict[str, float]:
        return dict(self._studio.seconds) if self._studio else {"render": 0.0, "metrics": 0.0}

    def shots(self) -> list[Taken]:
        names = (NEUTRAL, *self._character.expressions)
        with task("Rendering", len(names) * len(list(looks(self._settings)))) as advance:
            found = []
            for measured in chain.from_iterable(map(self.expression, names)):
                found.append(measured)
                advance()
        return found

    def expression(self, name: str) -> Iterator[Taken]:
        skins = [self._original(name), *(candidate.texture(name) for candidate in self._candidates)]
        return self._shots([Shot(name, *look) for look in looks(self._settings)], skins)

    def floors(self) -> dict[tuple[str, str], ImageMetrics]:
        """By view and light: every metric of the original neutral against itself with other random numbers."""
        skins = [self._original(NEUTRAL)]
        inputs, posed, floors = self._inputs(NEUTRAL, skins), None, dict[tuple[str, str], ImageMetrics]()
        for shot in (repeat_of(*look) for look in looks(self._settings)):
            name, digest = f"{shot.view.name}.{shot.light}.floor", self._digest(shot, inputs)
            floor = self._store.find(name, digest, ImageMetrics)
            if floor is None:
                posed = posed or self._posed(shot.expression, skins)
                floor = posed[0].floor(shot, posed[1])
                self._store.keep(name, digest, floor, {}, {})
            floors[shot.view.name, shot.light] = floor
        return floors

    def settle(self) -> None:
        """Wait until everything is on disk."""
        for future in self._writing:
            future.result()

    def finish(self) -> None:
        """Wait until everything is on disk, and leave nothing else there."""
        self.settle()
        self._store.prune()

    def _shots(self, shots: list[Shot], skins: list[SkinMaps]) -> Iterator[Taken]:
        inputs, posed = self._inputs(shots[0].expression, skins), None
        for shot in shots:
            digest = self._digest(shot, inputs)
            measured = self._store.find(shot.name, digest, Taken)
            if measured is None:
                posed = posed or self._posed(shot.expression, skins)
                measured, images = posed[0].take(shot, posed[1])
                self._keep(shot, digest, measured, images)
                self.rendered += 1
            yield measured

    def _posed(self, name: str, skins: list[SkinMaps]) -> tuple[Studio, list[Skin]]:
        if self._studio is None:
            neutral, face = self._character.meshes.neutral, face_triangles(self._character)
            self._studio = Studio(self._topology, neutral, face, self._settings, self._pool)
        self._studio.pose(self._character.mesh_vertices(name))
        return self._studio, [upload(maps, self._height) for maps in skins]

    @property
    def _height(self) -> float | None:
        """Of the head on its chart, where light scatters in the skin."""
        return spread(self._topology, self._character.meshes.neutral) if self._settings.material == "soft" else None

    def _inputs(self, name: str, skins: list[SkinMaps]) -> str:
        topology, character = self._topology, self._character
        meshes = character.meshes.neutral, character.mesh_vertices(name)
        present = [maps.present for maps in skins]
        arrays = [values for maps in present for values in maps.values()]
        names = {"maps": [list(maps) for maps in present]}
        return digest_of(names, (topology.faces, topology.uv, topology.face_uv, *meshes, *arrays))

    def _digest(self, shot: Shot, inputs: str) -> str:
        # Other views, lights and expressions do not change this one.
        settings = {key: value for key, value in plain(self._conditions).items() if key not in ("views", "lights")}
        look = {"view": vars(shot.view), "light": shot.light, "names": [one.name for one in self._candidates]}
        made = {"format": ValidationDocument.format, "renderer": REVISION, "inputs": inputs}
        return digest_of({**made, **settings, **look}, ())

    def _keep(self, shot: Shot, digest: str, measured: Taken, images: Images) -> None:
        names = ["original", *(f"{k + 1} {candidate.name}" for k, candidate in enumerate(self._candidates))]
        alpha = images.coverage[:, :, None]
        parts = {
            name: np.concatenate([linear, alpha], axis=2) for name, linear in zip(names, images.linear, strict=True)
        }
        facts = {"view": shot.view.name, "light": shot.light, "spp": str(measured.spp)}
        facts |= {key: str(getattr(self._conditions, key)) for key in ("seed", "material", "transport")}
        self._writing.append(self._pool.submit(self._store.keep, shot.name, digest, measured, parts, facts))
        if len(self._writing) > 4:
            # Rendering must not run ahead of writing: every pending shot holds its images.
            self._writing[-5].result()


def _conditions(character: Character, settings: Settings, versions: Versions) -> ValidationConditions:
    return ValidationConditions(
        **vars(versions),
        **vars(settings.resolved),
        sampler="multijitter, two independent halves",
        pixels_per_degree=PIXELS_PER_DEGREE,
        display="linear radiance clipped to 0..1, sRGB-encoded",
        region="pixels that the head fills at least half",
        texture_region="the character's mask" if character.masked else "whole texture",
        confidence="95 %, from two halves",
        debiased=["image_rmse_debiased", *DECIDING],
        units=UNITS,
    )
