"""Expressions x views x lights x packs: render, measure, and gather everything in one document."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character import NEUTRAL, Character, check_names
from facezip.errors import ErrorCode, FaceZipError
from facezip.progress import task
from render.exr import write_exr
from render.llvm import start
from render.metrics import METRICS, PIXELS_PER_DEGREE, UNITS, Picture, compare, display, head_crop
from render.noise import Halves, debiased_rmse, noise_floor
from render.paired import Images, PairedRenderer, upload
from render.verdict import verdict
from scenes.cameras import VIEWS, View, frame_of
from scenes.lights import RIGS
from scenes.materials import MATERIALS

FORMAT = "facezip-validation/1"
RENDERS = "renders"


@dataclass(frozen=True)
class Settings:
    """How to look.

    Attributes
    ----------
    views, lights : how many of :data:`scenes.cameras.VIEWS` and :data:`scenes.lights.RIGS`, in their order.
    resolution : width and height of the images in pixels.
    spp : samples per pixel, an even number: two independent halves.
    seed : of the random numbers; the second half takes the next one.
    material : a key of :data:`scenes.materials.MATERIALS`.
    """

    views: int = 2
    lights: int = 2
    resolution: int = 512
    spp: int = 16
    seed: int = 0
    material: str = "skin"

    def check(self) -> None:
        """Raise ``BAD_VALUE`` for the first setting outside its range."""
        ranges = {
            "views": (1, len(VIEWS)),
            "lights": (1, len(RIGS)),
            "resolution": (16, 8192),
            "spp": (2, 65536),
            "seed": (0, 2**31),
        }
        for name, (low, high) in ranges.items():
            if not low <= getattr(self, name) <= high:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"{name} {getattr(self, name)}: must lie in {low}..{high}")
        if self.spp % 2:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"spp {self.spp}: must be even, images are made of two halves")
        if self.material not in MATERIALS:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"material '{self.material}': must be one of {', '.join(MATERIALS)}"
            )


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is judged.

    Attributes
    ----------
    name : of the pack or character.
    texture : gives ``(H, W, C)`` float32 in [0, 1], encoded, for an expression or ``"neutral"``.
    facts : ``method``, ``bytes_on_gpu``, ``bytes_on_disk``, ``bytes_raw``, ``fetches``, ``texture_rmse`` and
        ``texture_rmse_per_expression``.
    """

    name: str
    texture: Callable[[str], NDArray[np.float32]]
    facts: dict[str, Any]


@dataclass(frozen=True)
class Shot:
    """One pose under one light, from one view."""

    expression: str
    view: View
    light: str

    @property
    def name(self) -> str:
        """The stem of its EXR file."""
        return f"{self.expression}.{self.view.name}.{self.light}"


def validate(
    character: Character, candidates: list[Candidate], folder: Path, settings: Settings | None = None
) -> dict[str, Any]:
    """Render the character with its own and each candidate's textures, and measure every difference.

    Writes ``folder/renders/EXPRESSION.VIEW.LIGHT.exr``: a part ``original`` and one a candidate.

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
    versions = start()
    (folder / RENDERS).mkdir(parents=True, exist_ok=True)
    frame = frame_of(character.neutral_vertices)
    rigs = list(RIGS)[: settings.lights]
    renderer = PairedRenderer(character.topology, frame, rigs, settings.material, settings.resolution)
    clock = {"render": 0.0}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        pending: list[Future[dict[str, Any]]] = []
        for shot, halves in _shots(character, candidates, renderer, settings, clock):
            pending.append(pool.submit(_measure, shot, halves, candidates, folder, settings))
            if len(pending) > 4:
                # Rendering must not run ahead of measuring: every pending shot holds its images.
                pending[-5].result()
        renders = [future.result() for future in pending]
        floors = list(pool.map(lambda pair: _noise_floor(*pair), _repeats(character, renderer, settings)))
    for render in renders:
        floor = next(
            floor for shot, floor in floors if (shot.view.name, shot.light) == (render["view"], render["light"])
        )
        render["noise_floor"] = floor | {"image_rmse": render["noise_floor"]}
    total = perf_counter() - begin
    return {
        "format": FORMAT,
        "character": _describe(character),
        "conditions": _conditions(character, settings, versions),
        "packs": [_summary(k, candidate, renders) for k, candidate in enumerate(candidates)],
        "renders": renders,
        "seconds": {"render": round(clock["render"], 2), "total": round(total, 2)},
        "pairs_per_second": round(len(renders) * len(candidates) / total, 2),
    }


def _shots(
    character: Character,
    candidates: list[Candidate],
    renderer: PairedRenderer,
    settings: Settings,
    clock: dict[str, float],
) -> Iterator[tuple[Shot, Halves]]:
    names = (NEUTRAL, *character.expressions)
    looks = _looks(settings)
    with task("Rendering", len(names) * len(looks)) as advance:
        for name in names:
            renderer.pose(character.mesh_vertices(name))
            maps = [upload(character.texture(name)), *(upload(candidate.texture(name)) for candidate in candidates)]
            for view, light in looks:
                begin = perf_counter()
                halves = [
                    renderer.render(maps, view, light, settings.spp // 2, 2 * settings.seed + half) for half in range(2)
                ]
                clock["render"] += perf_counter() - begin
                yield Shot(name, view, light), Halves(*halves)
                advance()


def _repeats(character: Character, renderer: PairedRenderer, settings: Settings) -> Iterator[tuple[Shot, list[Images]]]:
    """The neutral, twice, with independent random numbers and all samples: what noise alone does to every metric."""
    renderer.pose(character.neutral_vertices)
    maps = [upload(character.texture(NEUTRAL))]
    for view, light in _looks(settings):
        seeds = (2 * settings.seed, 2 * settings.seed + 2**20)
        images = [
            Halves(*(renderer.render(maps, view, light, settings.spp // 2, seed + half) for half in range(2))).mean
            for seed in seeds
        ]
        yield Shot(NEUTRAL, view, light), images


def _noise_floor(shot: Shot, images: list[Images]) -> tuple[Shot, dict[str, float | None]]:
    crop, head = head_crop(images[0].coverage), images[0].coverage >= 0.5
    return shot, compare(*(Picture(display(image.linear[0][crop]), head[crop]) for image in images))


def _looks(settings: Settings) -> list[tuple[View, str]]:
    return list(product(VIEWS[: settings.views], list(RIGS)[: settings.lights]))


def _measure(
    shot: Shot, halves: Halves, candidates: list[Candidate], folder: Path, settings: Settings
) -> dict[str, Any]:
    image = halves.mean
    file = f"{RENDERS}/{shot.name}.exr"
    alpha = image.coverage[:, :, None]
    names = ["original", *(f"{k + 1} {candidate.name}" for k, candidate in enumerate(candidates))]
    parts = {name: np.concatenate([linear, alpha], axis=2) for name, linear in zip(names, image.linear, strict=True)}
    conditions = {"view": shot.view.name, "light": shot.light, "spp": str(settings.spp), "seed": str(settings.seed)}
    write_exr(folder / file, parts, conditions)
    crop = head_crop(image.coverage)
    head = image.coverage >= 0.5
    pictures = [Picture(display(linear[crop]), head[crop]) for linear in image.linear]
    return {
        "expression": shot.expression,
        "view": shot.view.name,
        "light": shot.light,
        "exr": file,
        "noise_floor": noise_floor(halves, head),
        "packs": [
            compare(pictures[0], picture) | {"image_rmse_debiased": debiased_rmse(halves, k, head)}
            for k, picture in enumerate(pictures[1:], start=1)
        ],
    }


def _summary(k: int, candidate: Candidate, renders: list[dict[str, Any]]) -> dict[str, Any]:
    means = {
        metric: float(np.mean([render["packs"][k][metric] for render in renders]))
        for metric in (*METRICS, "image_rmse_debiased")
    }
    rmse = means["image_rmse"]
    pack = {
        **candidate.facts,
        "name": candidate.name,
        **means,
        "psnr": None if rmse == 0 else float(20 * np.log10(255 / rmse)),
        "noise_floor": float(np.mean([render["noise_floor"]["image_rmse"] for render in renders])),
        "noise_floor_per_metric": {
            metric: float(np.mean([render["noise_floor"][metric] for render in renders])) for metric in METRICS
        },
        "worst": {metric: _worst(k, metric, renders) for metric in (*METRICS, "image_rmse_debiased")},
    }
    level, sentence = verdict(pack)
    return pack | {"level": level, "verdict": sentence}


def _worst(k: int, metric: str, renders: list[dict[str, Any]]) -> dict[str, Any]:
    sign = -1 if metric == "ssim" else 1
    render = max(renders, key=lambda render: sign * render["packs"][k][metric])
    where = {key: render[key] for key in ("expression", "view", "light")}
    return {"value": render["packs"][k][metric], **where}


def _describe(character: Character) -> dict[str, Any]:
    return {
        "name": character.name,
        "expressions": list(character.expressions),
        "resolution": list(character.resolution),
        "channels": character.neutral.shape[2],
        "vertices": len(character.neutral_vertices),
        "triangles": len(character.topology.faces),
    }


def _conditions(character: Character, settings: Settings, versions: dict[str, str]) -> dict[str, Any]:
    return {
        **versions,
        "spp": settings.spp,
        "sampler": "multijitter, two independent halves",
        "seed": settings.seed,
        "light_transport": "direct",
        "skin": settings.material,
        "resolution": settings.resolution,
        "views": [view.name for view in VIEWS[: settings.views]],
        "lights": list(RIGS)[: settings.lights],
        "pixels_per_degree": PIXELS_PER_DEGREE,
        "display": "linear radiance clipped to 0..1, sRGB-encoded",
        "region": "pixels that the head fills at least half",
        "texture_region": "whole texture" if character.mask is None else "the character's mask",
        "units": UNITS,
    }
