"""The renders that ``bench render`` and ``bench metrics`` share: their options, textures and conditions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from facezip.character.loading import load_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.fit.methods import compress
from facezip.machine.conditions import Conditions, conditions
from render.limits import Thresholds
from scenes.cameras import View

if TYPE_CHECKING:
    from render.bench import Pose
    from render.settings import Settings

LIBRARIES = ("facezip", "mitsuba", "drjit", "numpy", "numba")
TEXELS = 512


@dataclass(frozen=True, kw_only=True)
class BenchConditions(Conditions):
    """The machine, what was rendered, and how."""

    views: Sequence[View]
    lights: Sequence[str]
    material: str
    transport: str
    resolution: int
    spp: int
    max_spp: int
    seed: int
    thresholds: Thresholds
    character: str
    texels: tuple[int, int]
    expressions: int
    packs: int


def shot_options(command: Callable[..., None]) -> Callable[..., None]:
    """What is rendered, in the order of ``--help``."""
    count = click.IntRange(min=1)
    for option in reversed(
        (
            click.option("--character", type=options.FOLDER, metavar="FOLDER", help="Scans; the embedded one if none."),
            click.option("--packs", type=click.IntRange(1, 15), default=2, show_default=True, metavar="N"),
            click.option("--expressions", type=count, default=2, show_default=True, metavar="N"),
            click.option("--views", type=count, default=1, show_default=True, metavar="N"),
            click.option("--lights", type=count, default=2, show_default=True, metavar="N"),
            click.option("--material", type=click.Choice(["skin", "diffuse"]), default="skin", show_default=True),
            click.option("--transport", type=click.Choice(["direct", "full"]), default="direct", show_default=True),
            click.option("--resolution", type=int, default=512, show_default=True, metavar="PIXELS"),
            click.option("--spp", type=int, default=16, show_default=True, metavar="N"),
            click.option("--seed", type=int, default=0, show_default=True, metavar="S"),
        )
    ):
        command = option(command)
    return options.as_json(command)


def make_poses(character: Path | None, packs: int, expressions: int, seed: int) -> "tuple[Character, list[Pose]]":
    """Scans, and their first expressions, each with its original texture and those of PCA with 1, 2, … differences."""
    from render.bench import Pose
    from scenes.character import make_character

    scans = load_character(character) if character else make_character(TEXELS, max(expressions, packs + 2), seed)
    # With orthonormal weights, fewer components are the first of more.
    models = [compress(scans, method="pca", differences=count) for count in range(1, packs + 1)]
    return scans, [
        Pose(scans.mesh_vertices(name), [scans.texture(name), *(one.reconstruct(name) for one in models)])
        for name in scans.expressions[:expressions]
    ]


def stated(scans: Character, poses: "list[Pose]", settings: "Settings") -> BenchConditions:
    """The conditions of every number: machine, versions, settings, and what is rendered."""
    return BenchConditions(
        **vars(conditions(LIBRARIES)),
        **vars(settings.resolved),
        character=scans.name,
        texels=scans.first.resolution,
        expressions=len(poses),
        packs=len(poses[0].textures) - 1,
    )
