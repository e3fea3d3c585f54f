"""``facezip validate``: path-traced proof, a character against packs of it."""

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

import click

from facezip.batch.workers import crew
from facezip.character.loading import load_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import error_words
from facezip.errors import ExitCode, FaceZipError
from facezip.files.writing import resumable_folder
from facezip.machine.memory import beside, limited

if TYPE_CHECKING:
    from render.documents.validation import ValidationDocument
    from render.settings import Settings
    from render.validation import Candidate, Filled, Filler

REPORT_FILE = "report.json"


@click.command("validate")
@click.argument("character", type=options.FOLDER)
@click.argument("packs", type=options.FOLDER, nargs=-1, required=True, metavar="PACK...")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option("--config", type=options.FOLDER, metavar="FILE.toml", help="Settings: views, lights, samples, limits.")
@click.option("--views", type=int, metavar="N", help="How many camera views.  [default: 2]")
@click.option("--lights", type=int, metavar="N", help="How many light rigs.  [default: 2]")
@click.option(
    "--material",
    type=click.Choice(["skin", "diffuse", "soft"]),
    help="Material of the head.  [default: skin]",
)
@click.option(
    "--transport",
    type=click.Choice(["direct", "full"]),
    help="One bounce, or more.  [default: direct]",
)
@click.option("--resolution", type=int, metavar="PIXELS", help="Side of the rendered images.  [default: 512]")
@click.option("--spp", type=int, metavar="N", help="Samples per pixel to begin with.  [default: 16]")
@click.option("--max-spp", type=int, metavar="N", help="Most samples, where it is close.  [default: 4 x spp]")
@click.option("--seed", type=int, metavar="S", help="Seed of all random numbers.  [default: 0]")
@click.option("--fail-on", type=click.Choice(["visible", "fails"]), help="Exit with 7 if a pack is as bad as that.")
@options.worker_options
@options.memory_of_each
@options.overwrite
@options.as_json
def command(
    character: Path,
    packs: tuple[Path, ...],
    output: Path,
    config: Path | None,
    workers: int | None,
    scheduler: str | None,
    memory: int | None,
    fail_on: str | None,
    overwrite: bool,
    as_json: bool,
    **given: Any,
) -> int:
    """Render every expression of CHARACTER with its own textures and with each PACK's, and report the difference.

    Both sides use the same light paths, so noise cancels in the difference. Instead of a PACK you may give a second
    CHARACTER, to judge textures that another tool made.

    Albedo, normal, roughness, specular and cavity maps are rendered, on all UDIM tiles.

    A run that was broken off goes on where it was. With --overwrite, renders of the old report are kept if nothing that
    made them has changed. Without --workers and --scheduler, one process renders on all cores.
    """
    from render.limits import LEVELS
    from render.settings import read_settings

    settings = read_settings(config, {key: value for key, value in given.items() if value is not None})

    def distribute(names: Sequence[str], folder: Path, earlier: Path | None) -> "list[Filled]":
        if workers is None and scheduler is None:
            return []
        paths = character.absolute(), tuple(path.absolute() for path in packs), folder.absolute()
        share = Share(*paths, earlier.absolute() if earlier else None, settings, memory, os.urandom(8).hex())
        return _filled(share, names, workers, scheduler)

    with limited(memory, beside(output)):
        scans, candidates = _loaded(character, packs, settings)
        document = _validate_into(scans, candidates, output, overwrite, settings, distribute)
    options.answer(document, as_json, lambda: _lines(document, output))
    worst = max(LEVELS.index(pack.level) for pack in document.packs)
    return ExitCode.DIFFERENCE if fail_on and worst >= LEVELS.index(fail_on) else ExitCode.DONE


def _loaded(character: Path, packs: Sequence[Path], settings: "Settings") -> "tuple[Character, list[Candidate]]":
    """The scans, and what is judged; raises where a limit of memory has no room for rendering them."""
    from render.budget import check_budget
    from render.candidates import candidate

    scans = load_character(character)
    check_budget(scans, 1 + len(packs), settings)
    return scans, [candidate(scans, path) for path in packs]


def _validate_into(
    scans: Character,
    candidates: "list[Candidate]",
    output: Path,
    overwrite: bool,
    settings: "Settings",
    distribute: "Callable[[Sequence[str], Path, Path | None], list[Filled]]",
) -> "ValidationDocument":
    """Render, measure and report into the folder ``output``; returns the report's document."""
    from render.validation import validate
    from reports.validation import write_validation_report

    earlier = output if output.is_dir() else None
    with resumable_folder(output, overwrite, lambda folder: (folder / REPORT_FILE).is_file()) as folder:
        document = validate(
            scans, candidates, folder, settings, earlier, lambda names: distribute(names, folder, earlier)
        )
        write_validation_report(document, folder)
    return document


@dataclass(frozen=True)
class Share:
    """What a worker is told of a validation; ``run`` is one run's own, so that no worker takes old files for new."""

    character: Path
    packs: tuple[Path, ...]
    folder: Path
    earlier: Path | None
    settings: "Settings"
    memory: int | None
    run: str


# A worker keeps what it has loaded and compiled from one expression to the next; its threads take turns.
_rendering = Lock()
# The limit of memory and the threads that it has for as long.
_held = ExitStack()


def fill(share: Share, name: str) -> "Filled":
    """One task: every shot of an expression that is not there yet."""
    with _rendering:
        return _filler(share).fill(name)


@lru_cache(maxsize=1)
def _filler(share: Share) -> "Filler":
    from render.validation import Filler

    _held.close()
    _held.enter_context(limited(share.memory, beside(share.folder)))
    scans, candidates = _loaded(share.character, share.packs, share.settings)
    return _held.enter_context(Filler(scans, candidates, share.folder, share.settings, share.earlier))


def _filled(share: Share, names: Sequence[str], workers: int | None, scheduler: str | None) -> "list[Filled]":
    with crew(workers, scheduler, len(names)) as hands:
        outcomes = hands.outcomes(fill, {name: (share, name) for name in names}, "Rendering expressions")
    for name, outcome in outcomes.items():
        if isinstance(outcome, FaceZipError):
            raise FaceZipError(outcome.code, f"{name}: {outcome}")
    return [outcome for outcome in outcomes.values() if not isinstance(outcome, FaceZipError)]


def _lines(document: "ValidationDocument", output: Path) -> list[str]:
    lines = []
    for pack in document.packs:
        lines += [
            f"{pack.name}: {pack.verdict}",
            f"  texture RMSE {pack.texture_rmse:.2f}, image RMSE {pack.image_rmse:.2f} of 255 "
            f"(noise floor {pack.noise_floor:.2f}), dE2000 p95 {pack.delta_e_p95:.2f}, FLIP {pack.flip:.4f}, "
            f"SSIM {pack.ssim:.4f}",
            *(f"  {name:<10} {error_words(found)}" for name, found in pack.map_errors.items()),
        ]
    count, rendered, seconds = len(document.renders), document.rendered, document.seconds
    taken = f", {count - rendered} taken over" if rendered < count else ""
    lines.append(f"{rendered} renders in {seconds.render:.1f} s, measured in {seconds.metrics:.1f} s{taken}")
    return [*lines, f"{output / 'index.html'}"]
