"""What is measured for Figure 8: albedos of generated shapes on every tile, made in three ways, against the truth."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.cleaning.steps import clean
from facezip.documents.document import from_plain, plain
from facezip.files.images import to_float
from facezip.fit.methods import compress
from facezip.machine.progress import track
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import quantise
from facezip.rigging.fit import Rig, fit_rig
from facezip.rigging.originals import Originals
from facezip.rigging.rigged import rigged
from facezip.rigging.template import Template
from facezip.rigging.weightmaps import Examples
from reports.paper.documents.figures import ShapesFigure
from reports.paper.documents.rig import GeometryErrors, RigBench, RigIntervals, RigNumbers, ShapeErrors
from reports.paper.strips import strips
from scenes.character import Person, make_character
from scenes.face.shapes import ARKIT_SHAPES
from scenes.template import embedded_template

Texture = NDArray[np.float32]
# Gives ``(H, W, C)`` float32 in [0, 1], the albedo of a shape on a tile.
Textures = Callable[[str, int], Texture]
PICTURES = 8
# Method, key of a document → compression and weight maps.
PACKS = {"paper": ("paper", "pseudo-inverse"), "ours": ("refined", "geometry-aware")}


@dataclass(frozen=True, eq=False)
class Generated:
    """One character with the shapes of a template.

    Attributes
    ----------
    scans : the character.
    cleaned : the same without what the capture added, as ours takes it.
    shapes : M names.
    rig : the shapes and what every scan is made of.
    textures : by method: ``naive``, ``paper``, ``ours``, the latter two as packs store them.
    damping : of our weight maps, as chosen.
    seconds : of the rig, and of each method's compression and weight maps.
    """

    scans: Character
    cleaned: Character
    shapes: tuple[str, ...]
    rig: Rig
    textures: dict[str, Textures]
    damping: float
    seconds: dict[str, float]


def bench_rig(resolution: int, seed: int, template_seed: int, seeds: int = 1) -> RigBench:
    """What ``facezip bench rig`` measures: mean errors of every method with nuisances, and ``clean`` without.

    With several ``seeds``, persons and templates are those from ``seed`` and ``template_seed`` on: numbers are means,
    ``intervals`` half the width of their 95 % intervals (Student's), and ``per_seed`` holds each document.
    """
    found = [_bench_one(resolution, seed + n, template_seed + n) for n in range(seeds)]
    if seeds == 1:
        return RigBench(**vars(found[0]))
    numbers = [plain(one) for one in found]
    mean, spread = from_plain(_mean(numbers), RigNumbers), from_plain(_intervals(numbers), RigIntervals)
    return RigBench(**vars(mean), intervals=spread, per_seed=found)


def _bench_one(resolution: int, seed: int, template_seed: int) -> RigNumbers:
    person = Person.make(resolution, seed)
    template = embedded_template(template_seed)
    captured = generate(make_character(resolution, seed=seed), template, seed)
    rig = captured.rig
    clean_scans = make_character(resolution, seed=seed, nuisances=0)
    return RigNumbers(
        **vars(_errors(captured, person)),
        shapes=len(ARKIT_SHAPES),
        clean=_errors(generate(clean_scans, template, seed, rig), person),
        geometry=geometry_errors(rig, person.deltas),
        condition=Examples.of(rig.weights).condition,
        seconds=captured.seconds,
    )


def _errors(generated: Generated, person: Person) -> ShapeErrors:
    textures = {**generated.textures, "neutral": neutral_of(generated.scans), "cleaned": neutral_of(generated.cleaned)}
    errors = texture_errors(replace(generated, textures=textures), lambda shape, _: person.texture({shape: 1.0}))
    ratios = [errors["ours"][shape] / errors["neutral"][shape] for shape in generated.shapes]
    means = mean_errors(errors)
    return ShapeErrors(
        **{name: means[name] for name in ("naive", "paper", "ours", "neutral", "cleaned")},
        ours_to_neutral=means["ours"] / means["neutral"],
        worse_than_neutral=sum(ratio > 1 for ratio in ratios),
        worst_ratio=max(ratios),
        damping=generated.damping,
        rmse_per_shape=errors,
    )


def _mean(found: Sequence[Any]) -> Any:
    """Documents of one form as one: the means of their numbers."""
    if isinstance(found[0], Mapping):
        return {name: _mean([one[name] for one in found]) for name in found[0]}
    # A condition that is infinite is None in a document.
    if None in found:
        return None
    return sum(found) / len(found)


def _intervals(found: Sequence[Any]) -> Any:
    """Half the width of the 95 % interval of every mean but those of single shapes."""
    if isinstance(found[0], Mapping):
        kept = [name for name in found[0] if name != "rmse_per_shape"]
        return {name: _intervals([one[name] for one in found]) for name in kept}
    if None in found:
        return None
    return float(student.ppf(0.975, len(found) - 1) * np.std(found, ddof=1) / np.sqrt(len(found)))


def figure_8(scans: Character, template: Template, seed: int, truth: Textures | None) -> ShapesFigure:
    """Albedos of a template's shapes made in three ways, in pictures, and their errors where the truth is known.

    Pictures are data URIs of the shapes that change the skin most, one of each left and right pair.
    """
    made, neutral = generate(scans, template, seed), neutral_of(scans)
    textures = {**made.textures, "neutral": neutral}
    errors = None
    if truth is not None:
        errors = texture_errors(replace(made, textures=textures), truth)
        changes = errors["neutral"]
    else:
        ours = made.textures["ours"]
        changes = {shape: _rmse(scans, partial(ours, shape), partial(neutral, shape)) for shape in made.shapes}
    columns = {**({"truth": truth} if truth else {}), **made.textures}
    return ShapesFigure(
        resolution=scans.first.resolution,
        condition=Examples.of(made.rig.weights).condition,
        damping=made.damping,
        unseen=[shape for shape, seen in zip(made.shapes, made.rig.seen, strict=True) if not seen],
        columns=list(columns),
        pictures=strips(scans, columns, _telling(changes)),
        rmse=mean_errors(errors) if errors else None,
        rmse_per_expression=errors,
    )


def _telling(changes: Mapping[str, float]) -> list[str]:
    """The shapes with the largest changes, without the right one of a pair."""
    names = [name for name in changes if not (name.endswith("Right") and f"{name[:-5]}Left" in changes)]
    return sorted(names, key=lambda name: -changes[name])[:PICTURES]


def generate(scans: Character, template: Template, seed: int, rig: Rig | None = None) -> Generated:
    """Rig the scans, unless ``rig`` is given, and make the textures of the shapes in the three ways of Figure 8.

    Ours are made of the cleaned scans, the others of the scans as they are.
    """
    begin = perf_counter()
    moved = scans.meshes.vertices - scans.meshes.neutral
    faces = scans.meshes.topology.faces
    rig = rig or fit_rig(scans.meshes.neutral, moved, faces, template.neutral, template.deltas)
    seconds = {"rig": perf_counter() - begin}
    textures: dict[str, Textures] = {"naive": naive(scans, template.shapes, rig)}
    damping, cleaned = 0.0, clean(scans).character
    for name, (method, maps) in PACKS.items():
        begin = perf_counter()
        some = cleaned if name == "ours" else scans
        made = rigged(some, compress(some, method, seed=seed), rig, template.shapes, maps)
        textures[name] = _of_model(quantise(made.model).dequantised())
        seconds[name] = perf_counter() - begin
        damping = made.damping or damping
    return Generated(scans, cleaned, template.shapes, rig, textures, damping, seconds)


def naive(scans: Character, shapes: tuple[str, ...], rig: Rig) -> Textures:
    """The paper's baseline: the weighted sum of the scans' differences, I_0 + Σ_n B⁺_mn (I_n - I_0)."""
    shares = Examples.of(rig.weights).inverse
    originals = Originals(scans, shapes, shares, scans.meshes.neutral, rig.deltas, "the naive sum of differences")
    return lambda shape, tile: originals.texels({shape: 1.0}, (ALBEDO, tile))


def neutral_of(scans: Character) -> Textures:
    """The scanned neutral in the place of every shape."""
    return lambda _, tile: to_float(scans.stacks[ALBEDO, tile].neutral)


def _of_model(model: CompressedTextures) -> Textures:
    return lambda shape, tile: model.texels({shape: 1.0}, (ALBEDO, tile))


def texture_errors(generated: Generated, truth: Textures) -> dict[str, dict[str, float]]:
    """RMSE, 0..255, of every method and shape over all tiles, inside the mask."""
    errors: dict[str, dict[str, float]] = {name: {} for name in generated.textures}
    for shape in track(generated.shapes, "Measuring shapes", len(generated.shapes)):
        true = {tile: truth(shape, tile) for tile in generated.scans.tiles}
        for name, texture in generated.textures.items():
            errors[name][shape] = _rmse(generated.scans, partial(texture, shape), true.__getitem__)
    return errors


def geometry_errors(rig: Rig, true: NDArray[np.float32]) -> GeometryErrors:
    """Mean vertex error over mean true displacement ``(M, V, 3)``, of the transferred and of the generated shapes."""
    size = np.linalg.norm(true, axis=2).mean()

    def error(found: NDArray[np.float32]) -> float:
        return float(np.linalg.norm(found - true, axis=2).mean() / size)

    return GeometryErrors(transferred=error(rig.transferred), ours=error(rig.deltas))


def mean_errors(errors: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """The mean over shapes of every method's RMSE."""
    return {name: sum(one.values()) / len(one) for name, one in errors.items()}


def _rmse(scans: Character, texture: Callable[[int], Texture], true: Callable[[int], Texture]) -> float:
    """Of textures by tile, inside the mask."""
    total = seen = 0.0
    for tile, stack in scans.of_map(ALBEDO).items():
        weight = stack.weight
        squares = np.square(texture(tile) - true(tile), dtype=np.float64).mean(axis=2)
        total, seen = total + float(np.sum(squares * weight)), seen + float(weight.sum(dtype=np.float64))
    return float(255 * np.sqrt(total / seen))
