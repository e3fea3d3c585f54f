"""What is kept: the command line as its users call it, on characters of several sizes, each beside its images alone."""

import io
import json
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.machine.progress import track
from reports.kept.rows import Row
from scenes.character import make_character
from scenes.face.capture import MAPS

EXPRESSIONS = 20
# Words after ``facezip compress scans -o me.facezip``.
METHODS = {
    "refined": (),
    "nonnegative": ("--nonnegative",),
    "masks": ("--method", "masks"),
    "paper": ("--method", "paper"),
    "paper-unpermuted": ("--method", "paper-unpermuted"),
    "pca-4": ("--method", "pca", "--differences", "4"),
    "pca-8": ("--method", "pca", "--differences", "8"),
}
LIBRARIES = ("facezip", "numpy", "numba", "scipy", "scikit-learn")


@dataclass(frozen=True)
class Subject:
    """A character of one size: ``folder`` of a capture, or a ``seed`` and ``maps`` besides the albedo."""

    name: str
    size: int
    seed: int = 0
    maps: tuple[str, ...] = ()
    folder: Path | None = None
    methods: tuple[str, ...] = tuple(METHODS)

    def scans(self, work: Path) -> Path:
        """Its folder, made in ``work`` where there is none yet."""
        if self.folder:
            return self.folder
        save_character(make_character(self.size, EXPRESSIONS, self.seed, maps=self.maps), work / "scans")
        return work / "scans"


# Compiles every kernel, so it has no times; small enough to measure again in a test.
FIRST = Subject("embedded", 64)
USUAL = (
    Subject("embedded", 256),
    Subject("embedded", 512),
    Subject("embedded-1", 256, seed=1),
    Subject("embedded-maps", 512, maps=MAPS[:2], methods=("refined",)),
)
LARGE = (Subject("embedded", 1024), Subject("embedded", 2048, methods=("refined",)))


def measure(subjects: Sequence[Subject]) -> Iterator[Row]:
    """The rows of :data:`FIRST` and of ``subjects``, each as soon as it is measured."""
    for subject in track((FIRST, *subjects), "Measuring", 1 + len(subjects)):
        with TemporaryDirectory(prefix="facezip-kept-") as place:
            yield from rows_of(subject, Path(place), timed=subject is not FIRST)


def rows_of(subject: Subject, work: Path, timed: bool) -> Iterator[Row]:
    """The rows of one subject; ``work`` is an existing folder for what is made, ``timed`` says whether times count."""
    scans = subject.scans(work)
    images = answer("bench", "compress", "--character", scans, "--repeats", 1)["io_s"] if timed else None
    for method in subject.methods:
        words = METHODS[method]
        document = answer("compress", scans, "-o", work / f"{method}.facezip", *words)
        row = _row(subject, method, document)
        yield replace(row, time=document["seconds"] / images if images else None)
    yield replace(
        row,
        method="textures",
        rmse=0.0,
        bytes_on_gpu=document["bytes_raw"],
        bytes_bc7=document["bytes_raw_bc7"],
        bits=row.bits * document["bytes_raw_bc7"] / document["bytes_bc7"],
        fetches=(1 + row.expressions) * len(document["maps"]),
        time=None,
        command="",
    )


def answer(*words: object) -> dict[str, Any]:
    """What ``facezip`` says to a program, in this process: kernels are loaded once for all."""
    said = io.StringIO()
    with redirect_stdout(said):
        facezip.main([*map(str, words), "--json"], standalone_mode=False)
    found: dict[str, Any] = json.loads(said.getvalue())
    return found


def _row(subject: Subject, method: str, document: dict[str, Any]) -> Row:
    return Row(
        character=subject.name,
        size=subject.size,
        expressions=len(document["expressions"]),
        method=method,
        rmse=document["rmse"],
        bytes_on_gpu=document["bytes_on_gpu"],
        bytes_bc7=document["bytes_bc7"],
        bits=document["bits_per_texel_channel"],
        fetches=document["fetches"],
        time=None,
        versions=", ".join(f"{name} {version(name)}" for name in LIBRARIES),
        command=" ".join(("compress scans -o me.facezip", *METHODS[method])),
    )
