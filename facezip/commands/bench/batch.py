"""``facezip bench batch``: a dask cluster beside the process pool, and what a killed worker costs."""

import logging
import os
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, Literal

import click

from facezip.batch.workers import Crew, crew
from facezip.character.loading import save_character
from facezip.commands import options
from facezip.commands.batch import compress_unless_finished
from facezip.commands.fit_options import DEFAULTS, request_of
from facezip.documents.document import Document
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.pipeline import compress_into
from facezip.machine.conditions import Conditions, conditions
from facezip.machine.progress import track
from facezip.pack.verification import verify_pack

if TYPE_CHECKING:
    from distributed import LocalCluster

# Dask looks at what its workers do a hundred times a second, and has them give back every free page: a third more
# processor time for work on large arrays.
LEAN = {
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ": {"MALLOC_TRIM_THRESHOLD_": 2**28, "MALLOC_MMAP_THRESHOLD_": 2**25},
}
# How often the killer looks whether half of the packs are there.
INTERVAL = 0.01


@dataclass(frozen=True, kw_only=True)
class IdenticalPacks:
    """How many packs verify and have the bytes of those made one by one, by run."""

    pool: int
    dask: int
    killed: int


@dataclass(frozen=True, kw_only=True)
class BatchBench:
    """Four runs over the same characters.

    Attributes
    ----------
    serial_s, pool_s, dask_s, killed_s : wall time: one by one, by the process pool, by dask, and with a worker killed.
    serial_cpu_s, pool_cpu_s, dask_cpu_s, killed_cpu_s : processor time of the same.
    overhead, overhead_cpu : of dask over the pool, as shares.
    workers_killed : how many.
    identical : packs of each run that are as they should be.
    """

    serial_s: float
    serial_cpu_s: float
    pool_s: float
    pool_cpu_s: float
    dask_s: float
    dask_cpu_s: float
    killed_s: float
    killed_cpu_s: float
    overhead: float
    overhead_cpu: float
    workers_killed: int
    identical: IdenticalPacks


@dataclass(frozen=True, kw_only=True)
class BatchBenchConditions(Conditions):
    """What was compressed by whom, and the runs in words."""

    character: str
    characters: int
    resolution: tuple[int, int]
    expressions: int
    workers: int
    threads_per_worker: int
    serial: str
    dask: str
    killed: str


@dataclass(frozen=True, kw_only=True)
class BatchBenchDocument(BatchBench, Document):
    """A dask cluster beside the process pool, and what a killed worker costs.

    Attributes
    ----------
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-batch/1"] = "facezip-bench-batch/1"
    conditions: BatchBenchConditions


@click.command("batch")
@click.option("--characters", type=click.IntRange(min=2), default=12, show_default=True, metavar="N")
@click.option("--resolution", type=click.IntRange(64, 8192), default=1024, show_default=True, metavar="TEXELS")
@click.option("--expressions", type=click.IntRange(min=2), default=8, show_default=True, metavar="N")
@click.option("--workers", type=click.IntRange(min=1), default=2, show_default=True, metavar="N")
@options.as_json
def command(characters: int, resolution: int, expressions: int, workers: int, as_json: bool) -> None:
    """Compress the same embedded heads one by one, with the process pool, and with a local dask cluster.

    Pool and cluster have equally many workers of one thread. Times include the start of their processes. Processor
    time, unlike wall time, hardly depends on what else the machine does. In a second run of the cluster, one worker is
    killed once half of the packs are there. Every pack is verified and compared, byte for byte, with that of the serial
    run.
    """
    with TemporaryDirectory(prefix="facezip-bench-") as place:
        work = Path(place)
        found = _measured(work, _made(work / "scans", characters, resolution, expressions, workers), workers)
    about = BatchBenchConditions(
        **vars(conditions(("facezip", "numpy", "numba", "distributed"))),
        character="embedded, one seed each",
        characters=characters,
        resolution=(resolution, resolution),
        expressions=expressions,
        workers=workers,
        threads_per_worker=1,
        serial="in one process, all cores",
        dask="its settings as docs/batch.md has them",
        killed="SIGKILL to one worker once half of the packs are finished",
    )
    document = BatchBenchDocument(**vars(found), conditions=about)
    options.answer(document, as_json, lambda: _lines(document))


def make_scans(folder: Path, resolution: int, expressions: int, seed: int) -> None:
    """One task: an embedded character with this seed, saved to ``folder``."""
    from scenes.character import make_character

    save_character(make_character(resolution, expressions, seed), folder)


def _made(place: Path, characters: int, resolution: int, expressions: int, workers: int) -> list[Path]:
    folders = {f"seed_{seed}": place / f"seed_{seed}" for seed in range(characters)}
    tasks = {name: (folder, resolution, expressions, seed) for seed, (name, folder) in enumerate(folders.items())}
    with crew(workers, None, characters) as hands:
        _or_raise(hands.outcomes(make_scans, tasks, "Making characters"))
    return list(folders.values())


def _measured(work: Path, scans: list[Path], workers: int) -> BatchBench:
    settings = DEFAULTS
    seconds: dict[str, float] = {}
    with _clocked(seconds, "serial"):
        for folder in track(scans, "One by one", len(scans)):
            compress_into(folder, work / "serial" / f"{folder.name}.facezip", request_of(settings))
    with _clocked(seconds, "pool"), crew(workers, None, len(scans)) as hands:
        _compress(replace(hands, threads=1), scans, work / "pool", settings)
    with _clocked(seconds, "dask"), _cluster(workers) as cluster, crew(None, cluster.scheduler_address, 1) as hands:
        _compress(hands, scans, work / "dask", settings)
    with (
        _clocked(seconds, "killed"),
        _cluster(workers) as cluster,
        crew(None, cluster.scheduler_address, 1) as hands,
        _killing(cluster, work / "killed", len(scans) // 2) as killed,
    ):
        _compress(hands, scans, work / "killed", settings)
    same = {run: _equal(work / run, work / "serial", scans) for run in ("pool", "dask", "killed")}
    return BatchBench(
        **{name: round(value, 3) for name, value in seconds.items()},
        overhead=round(seconds["dask_s"] / seconds["pool_s"] - 1, 4),
        overhead_cpu=round(seconds["dask_cpu_s"] / seconds["pool_cpu_s"] - 1, 4),
        workers_killed=len(killed),
        identical=IdenticalPacks(**same),
    )


@contextmanager
def _clocked(seconds: dict[str, float], name: str) -> Iterator[None]:
    """Wall time, and processor time of this process and of those that it has started and seen end."""
    before = os.times()
    yield
    spent = [after - earlier for after, earlier in zip(os.times(), before, strict=True)]
    seconds |= {f"{name}_s": spent[-1], f"{name}_cpu_s": sum(spent[:-1])}


def _compress(hands: Crew, scans: list[Path], output: Path, settings: Mapping[str, Any]) -> None:
    output.mkdir()
    tasks = {folder.name: (folder, output, folder.name, settings) for folder in scans}
    _or_raise(hands.outcomes(compress_unless_finished, tasks, output.name.capitalize()))


def _or_raise(outcomes: Mapping[str, object]) -> None:
    for outcome in outcomes.values():
        if isinstance(outcome, FaceZipError):
            raise outcome


@contextmanager
def _cluster(workers: int) -> Iterator["LocalCluster"]:
    try:
        from distributed import LocalCluster
    except ImportError:
        raise FaceZipError(
            ErrorCode.NO_SCHEDULER, "bench batch: dask is not installed; pip install 'facezip[cluster]'"
        ) from None
    import dask

    quiet = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    with (
        dask.config.set(LEAN),
        LocalCluster(n_workers=workers, threads_per_worker=1, host="127.0.0.1", **quiet) as cluster,
    ):
        yield cluster


@contextmanager
def _killing(cluster: "LocalCluster", output: Path, after: int) -> Iterator[list[int]]:
    """Kill one worker once ``after`` packs are finished; yields the list of those killed."""
    killed: list[int] = []
    over = Event()

    def watch() -> None:
        while not over.wait(INTERVAL):
            if len(list(output.glob("*.facezip"))) >= after:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)
                return

    killer = Thread(target=watch)
    killer.start()
    try:
        yield killed
    finally:
        over.set()
        killer.join()


def _equal(output: Path, serial: Path, scans: list[Path]) -> int:
    """How many packs verify and have the bytes of the serial run's."""
    return sum(_same_pack(output / f"{folder.name}.facezip", serial / f"{folder.name}.facezip") for folder in scans)


def _same_pack(one: Path, other: Path) -> bool:
    verify_pack(one)
    names = sorted(path.name for path in other.iterdir())
    alike = names == sorted(path.name for path in one.iterdir())
    return alike and all((one / name).read_bytes() == (other / name).read_bytes() for name in names)


def _lines(document: BatchBenchDocument) -> list[str]:
    about, same = document.conditions, document.identical
    count = about.characters
    return [
        f"{count} characters of {about.resolution[0]}², {about.expressions} expressions each, "
        f"{about.workers} workers of one thread",
        f"  one by one       {document.serial_s:8.2f} s  ({about.serial})",
        f"  process pool     {document.pool_s:8.2f} s  {same.pool} of {count} packs as one by one",
        f"  dask             {document.dask_s:8.2f} s  {same.dask} of {count}; overhead "
        f"{document.overhead:+.1%}, of processor time {document.overhead_cpu:+.1%}",
        f"  a worker killed  {document.killed_s:8.2f} s  {same.killed} of {count}",
    ]
