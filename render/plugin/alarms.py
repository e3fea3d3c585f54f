"""How often the test cries wolf, and what it finds: A/A comparisons, and the same with injected defects.

Renders of the embedded character from its compressed textures become a reference, others of the same textures and of
spoilt ones are compared with it; so are scenes with regions of one exact value. No render serves twice.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, cycle, islice, product
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from facezip.documents.document import Document
from facezip.fit.methods import compress
from facezip.machine.progress import track
from render.documents.conditions import Versions
from render.llvm import start
from render.paired import PairedRenderer
from render.plugin.defects import injected_defects
from render.plugin.flats import FLATS, FlatScene, flat_scenes
from render.plugin.reference import Reference
from render.skins import Skin, SkinMaps, upload
from scenes.cameras import VIEWS, frame_of
from scenes.character import make_character
from scenes.lights import RIGS
from scenes.materials import MATERIALS

LEVELS = (0.05, 0.01, 0.001)
CONFIDENCE = 0.95
# Samples per pixel of scenes with flat regions: as many as tests have.
FLAT_SPP = 16


@dataclass(frozen=True)
class Trials:
    """What is rendered and compared.

    Attributes
    ----------
    references, tests : how many references, spread over rigs and materials; how many tests against each.
    reference_renders, renders : independent renders in a reference, and in a test.
    resolution, spp : side of the images in pixels, samples per pixel of each render.
    texels : side of the textures.
    seed : of the first render; others follow.
    """

    references: int = 24
    tests: int = 10
    reference_renders: int = 32
    renders: int = 8
    resolution: int = 64
    spp: int = 100
    texels: int = 256
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Rate:
    """How often a test says that something has changed.

    Attributes
    ----------
    trials, count : comparisons, and those below the level.
    rate, interval : their ratio, and its 95 % interval (Clopper and Pearson 1934).
    """

    trials: int
    count: int
    rate: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class LevelRate(Rate):
    """The same at another level.

    Attributes
    ----------
    level : of the test.
    """

    level: float


@dataclass(frozen=True, kw_only=True)
class DefectRate(Rate):
    """How often a defect is found.

    Attributes
    ----------
    per_case : the rate of every ``rig, material``.
    """

    per_case: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class FlatRates:
    """Of one of :func:`render.plugin.flats.flat_scenes`.

    Attributes
    ----------
    levels : of equal renders.
    flat, noisy : of those in which that part is changed, where the scene has it.
    """

    levels: Sequence[LevelRate]
    flat: Rate | None = None
    noisy: Rate | None = None


@dataclass(frozen=True, kw_only=True)
class AlarmConditions(Trials, Versions):
    """How many trials of what, and how they were rendered."""

    sampler: str
    character: str


@dataclass(frozen=True, kw_only=True)
class AlarmsDocument(Document):
    """How often the test of the pytest plugin errs.

    Attributes
    ----------
    level : that the test promises not to exceed when nothing has changed.
    false_alarms : at that level.
    levels : at others.
    defects : by defect.
    flats : by scene with regions of one exact value.
    seconds : spent.
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-alarms/1"] = "facezip-bench-alarms/1"
    level: float
    false_alarms: Rate
    levels: Sequence[LevelRate]
    defects: Mapping[str, DefectRate]
    flats: Mapping[str, FlatRates]
    seconds: float
    conditions: AlarmConditions


def measure_alarms(trials: Trials, level: float) -> AlarmsDocument:
    """Compare equal and changed renders with references, and count what falls below the level."""
    begin = perf_counter()
    versions = start()
    found = _gathered(track(_comparisons(trials), "Comparing", trials.references * trials.tests))
    by_name = {name: {case: of[name] for case, of in found.items()} for name in next(iter(found.values()))}
    equal = np.concatenate([*by_name.pop(_EQUAL).values()])
    return AlarmsDocument(
        level=level,
        false_alarms=_rate(equal, level),
        levels=_levels(equal),
        defects={name: _rates(cases, level) for name, cases in by_name.items()},
        flats=_flats(trials, level),
        seconds=round(perf_counter() - begin, 2),
        conditions=AlarmConditions(
            **vars(versions), **vars(trials), sampler="multijitter", character="embedded, smile, refined"
        ),
    )


_EQUAL = "equal"


def _gathered(comparisons: Iterable[tuple[str, dict[str, float]]]) -> dict[str, dict[str, list[float]]]:
    """Probabilities by case and by what was compared."""
    found: dict[str, dict[str, list[float]]] = {}
    for case, probabilities in comparisons:
        for name, probability in probabilities.items():
            found.setdefault(case, {}).setdefault(name, []).append(probability)
    return found


def _rates(cases: dict[str, list[float]], level: float) -> DefectRate:
    per_case = {case: float(np.mean(np.array(values) < level)) for case, values in cases.items()}
    return DefectRate(**vars(_rate(np.concatenate([*cases.values()]), level)), per_case=per_case)


def _levels(probabilities: NDArray[np.float64]) -> list[LevelRate]:
    return [LevelRate(level=level, **vars(_rate(probabilities, level))) for level in LEVELS]


def _flats(trials: Trials, level: float) -> dict[str, FlatRates]:
    steps = FLATS * trials.references * trials.tests
    found = _gathered(track(_flat_comparisons(trials), "Comparing flats", steps))
    return {
        name: FlatRates(
            levels=_levels(np.array(changes.pop(_EQUAL))),
            **{change: _rate(np.array(values), level) for change, values in changes.items()},
        )
        for name, changes in found.items()
    }


def _flat_comparisons(trials: Trials) -> Iterator[tuple[str, dict[str, float]]]:
    """The same for scenes with flat regions, whose values differ from reference to reference."""
    seeds, rng = count(trials.seed), np.random.default_rng(trials.seed)
    for _ in range(trials.references):
        for scene in flat_scenes(rng.uniform(0.05, 0.95, 3), trials.resolution, FLAT_SPP):

            def light(renders: int, scene: FlatScene = scene) -> NDArray[np.float32]:
                return np.stack([scene.light(next(seeds)) for _ in range(renders)])

            reference = Reference.of(scene.pictures(light(trials.reference_renders))[_EQUAL])
            for _ in range(trials.tests):
                pictures = scene.pictures(light(trials.renders))
                yield scene.name, {name: reference.compare(images).probability for name, images in pictures.items()}


def _rate(probabilities: NDArray[np.float64], level: float) -> Rate:
    below = int(np.count_nonzero(probabilities < level))
    interval = stats.binomtest(below, len(probabilities)).proportion_ci(CONFIDENCE, method="exact")
    return Rate(
        trials=len(probabilities),
        count=below,
        rate=below / len(probabilities),
        interval=(float(interval.low), float(interval.high)),
    )


def _comparisons(trials: Trials) -> Iterator[tuple[str, dict[str, float]]]:
    """Probabilities of every test, equal and with each defect, and under which rig on which material it was."""
    character = make_character(trials.texels, 6)
    expression = character.expressions[0]
    model = compress(character, method="refined")
    textures = {_EQUAL: model.reconstruct(expression), **injected_defects(model, expression, character)}
    skins = [upload(SkinMaps(texture)) for texture in textures.values()]
    frame = frame_of(character.meshes.neutral)
    renderers = {
        material: PairedRenderer(character.meshes.topology, frame, list(RIGS), material, trials.resolution)
        for material in MATERIALS
    }
    for renderer in renderers.values():
        renderer.pose(character.mesh_vertices(expression))
    seeds = count(trials.seed)
    for rig, material in islice(cycle(product(RIGS, MATERIALS)), trials.references):
        look = renderers[material], rig, trials.spp
        equal = _renders(look, skins[:1], islice(seeds, trials.reference_renders))
        reference = Reference.of(equal[:, 0])
        for _ in range(trials.tests):
            tested = _renders(look, skins, islice(seeds, trials.renders))
            yield (
                f"{rig}, {material}",
                {name: reference.compare(tested[:, k]).probability for k, name in enumerate(textures)},
            )


def _renders(look: tuple[PairedRenderer, str, int], skins: Sequence[Skin], seeds: Iterator[int]) -> NDArray[np.float32]:
    """``(n, K, H, W, 3)`` renders with n seeds of K skins."""
    renderer, rig, spp = look
    return np.stack([renderer.render(skins, VIEWS[0], rig, spp, seed).linear for seed in seeds])
