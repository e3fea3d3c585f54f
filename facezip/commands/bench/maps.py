"""``facezip bench maps``: weight maps that several maps share, beside one fit for each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from facezip.character.loading import load_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.documents.document import Document
from facezip.fit.sharing import Way, compare_sharing
from facezip.machine.conditions import Conditions, conditions
from facezip.pack.errors import MapErrors


@dataclass(frozen=True, kw_only=True)
class MapsBenchConditions(Conditions):
    """What was fitted; ``seed`` and ``nuisances`` are null of scans."""

    character: str
    resolution: tuple[int, int]
    tiles: Sequence[int]
    expressions: int
    seed: int | None
    nuisances: float | None
    map_weights: str


@dataclass(frozen=True, kw_only=True)
class MapsBenchDocument(Document):
    """Weight maps that several maps share, beside one fit for each.

    Attributes
    ----------
    maps : of the character.
    ways : to fit them.
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-maps/1"] = "facezip-bench-maps/1"
    maps: Sequence[str]
    ways: Sequence[Way]
    conditions: MapsBenchConditions


@click.command("maps")
@options.scans
@options.resolution
@options.expressions
@options.seed
@click.option(
    "--nuisances", type=options.FiniteRange(0, 10), default=1.0, show_default=True, metavar="X", help="0: none."
)
@options.as_json
def command(
    character: Path | None,
    resolution: int,
    expressions: int,
    seed: int,
    nuisances: float,
    as_json: bool,
) -> None:
    """Measure what shared weight maps save and cost, against a fit for each map.

    Reports GPU memory, texture fetches and the errors of each map in the written packs: RMSE of 255 for colours and
    data, degrees for normals, inside the mask.
    """
    options.check_embedded(character, "resolution", "expressions", "seed", "nuisances")
    scans = load_character(character) if character else _embedded(resolution, expressions, seed, nuisances)
    document = MapsBenchDocument(
        maps=[kind.name for kind in scans.maps],
        ways=compare_sharing(scans),
        conditions=MapsBenchConditions(
            **vars(conditions(("facezip", "numpy", "numba"))),
            character=scans.name if character else "embedded",
            resolution=scans.first.resolution,
            tiles=scans.tiles,
            expressions=len(scans.expressions),
            seed=None if character else seed,
            nuisances=None if character else nuisances,
            map_weights="1 each: the differences of every map count alike in sum",
        ),
    )
    options.answer(document, as_json, lambda: _lines(document))


def _embedded(resolution: int, expressions: int, seed: int, nuisances: float) -> Character:
    from scenes.character import make_character
    from scenes.face.capture import MAPS

    return make_character(resolution, expressions, seed, nuisances, maps=MAPS[:2])


def _lines(document: MapsBenchDocument) -> list[str]:
    names, stated = document.maps, document.conditions
    lines = [
        f"{stated.expressions} expressions of {stated.resolution[1]} x {stated.resolution[0]} texels; "
        f"uncompressed {megabytes(document.ways[0].bytes_raw)}",
        f"  {'':24} {'GPU':>9} {'fetches':>8} {'packed':>7}" + "".join(f"{name:>12}" for name in names),
    ]
    for way in document.ways:
        errors = "".join(f"{_shown(way.errors[name]):>12}" for name in names)
        size = megabytes(way.bytes_on_gpu)
        lines.append(f"  {way.way:24} {size:>9} {way.fetches:>8} {way.fetches_packed:>7}{errors}")
    return [*lines, "  RMSE of 255 inside the mask; normals: mean angle in degrees"]


def _shown(found: MapErrors) -> str:
    return f"{found.mean:.3f}{'°' * found.is_angular}"
