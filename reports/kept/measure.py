"""What is kept: the command line as its users call it, on characters of several sizes, each beside its images alone."""

import io
import json
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.files.images import read_texture, read_texture_exactly, write_texture
from facezip.files.opening import TEXTURE_SUFFIXES
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


# Loads every kernel, so it has no times; small enough to measure again in a test.
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
    for method in subject.methods:
        pack, begin = work / f"{method}.facezip", process_time()
        document = answer("compress", scans, "-o", pack, *METHODS[method])
        seconds = process_time() - begin
        row = _row(subject, method, document)
        yield replace(row, cpu=seconds / _seconds_of_images(scans, pack, work) if timed else None)
    yield replace(
        row,
        method="textures",
        rmse=0.0,
        bytes_on_gpu=document["bytes_raw"],
        bytes_bc7=document["bytes_raw_bc7"],
        bits=row.bits * document["bytes_raw_bc7"] / document["bytes_bc7"],
        fetches=(1 + row.expressions) * len(document["maps"]),
        cpu=None,
        command="",
    )


def answer(*words: object) -> dict[str, Any]:
    """What ``facezip`` says to a program, in this process: kernels are loaded once for all."""
    said = io.StringIO()
    with redirect_stdout(said):
        facezip.main([*map(str, words), "--json"], standalone_mode=False)
    found: dict[str, Any] = json.loads(said.getvalue())
    return found


def _seconds_of_images(scans: Path, pack: Path, work: Path) -> float:
    """Processor time of what no compressor of textures can avoid: its images read, its own written."""
    written = {path.name: read_texture_exactly(path) for path in sorted(pack.glob("*.png"))}
    begin = process_time()
    for path in sorted(path for path in scans.iterdir() if path.suffix.lower() in TEXTURE_SUFFIXES):
        read_texture(path)
    for name, texels in written.items():
        write_texture(work / name, texels)
    return process_time() - begin


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
        cpu=None,
        versions=", ".join(f"{name} {version(name)}" for name in LIBRARIES),
        command=" ".join(("compress scans -o me.facezip", *METHODS[method])),
    )
