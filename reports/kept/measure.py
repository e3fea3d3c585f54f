"""What is kept: the command line as its users call it, on characters of several sizes, each beside its images alone."""

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.files.images import Texels, read_texture, read_texture_exactly, write_texture
from facezip.files.opening import TEXTURE_SUFFIXES
from facezip.machine.progress import track
from reports.kept.cost import cost
from reports.kept.inputs import COMPRESSING, EMBEDDED, digest, versions
from reports.kept.rows import Row
from scenes.character import make_character
from scenes.face.capture import MAPS

EXPRESSIONS = 20
# Words after ``facezip compress scans -o me.facezip``.
METHODS = {
    "refined": (),
    "refined-2G": ("--memory", "2G"),
    "nonnegative": ("--nonnegative",),
    "masks": ("--method", "masks"),
    "paper": ("--method", "paper"),
    "paper-unpermuted": ("--method", "paper-unpermuted"),
    "pca-4": ("--method", "pca", "--differences", "4"),
    "pca-8": ("--method", "pca", "--differences", "8"),
}
# Of a size that needs no limit.
EVERY = tuple(method for method in METHODS if method != "refined-2G")


@dataclass(frozen=True)
class Subject:
    """A character of one size: ``folder`` of a capture, or a ``seed`` and ``maps`` besides the albedo."""

    name: str
    size: int
    seed: int = 0
    maps: tuple[str, ...] = ()
    folder: Path | None = None
    methods: tuple[str, ...] = EVERY
    timed: bool = True

    def scans(self, work: Path) -> Path:
        """Its folder, made in ``work`` where there is none yet."""
        if self.folder:
            return self.folder
        save_character(make_character(self.size, EXPRESSIONS, self.seed, maps=self.maps), work / "scans")
        return work / "scans"

    @cached_property
    def inputs(self) -> str:
        """Digest of what its figures depend on."""
        code = COMPRESSING if self.folder else (*COMPRESSING, *EMBEDDED)
        return digest(code, self.folder, self.size, self.seed, self.maps)


# Too short to be timed; small enough to measure again in a test.
FIRST = Subject("embedded", 64, timed=False)
USUAL = (
    Subject("embedded", 256),
    Subject("embedded", 512),
    Subject("embedded-1", 256, seed=1),
    Subject("embedded-maps", 512, maps=MAPS[:2], methods=("refined",)),
)
LARGE = (
    Subject("embedded", 1024),
    Subject("embedded", 2048, methods=("refined",)),
    Subject("embedded", 4096, methods=("refined",)),
    Subject("embedded", 8192, methods=("refined-2G",)),
)


def stale(subject: Subject, rows: Mapping[str, Row]) -> Subject:
    """A subject with those of its methods alone whose rows are missing or of other inputs."""

    def is_stale(method: str) -> bool:
        row = rows.get(f"{subject.name}/{subject.size}/{method}")
        return row is None or row.inputs != subject.inputs

    return replace(subject, methods=tuple(method for method in subject.methods if is_stale(method)))


def measure(subjects: Sequence[Subject]) -> Iterator[Row]:
    """The rows of ``subjects``, each as soon as it is measured; nothing is made of a subject without methods."""
    chosen = [subject for subject in subjects if subject.methods]
    for subject in track(chosen, "Measuring", len(chosen)):
        with TemporaryDirectory(prefix="facezip-kept-") as place:
            yield from rows_of(subject, Path(place))


def rows_of(subject: Subject, work: Path) -> Iterator[Row]:
    """The rows of one subject; ``work`` is an existing folder for what is made."""
    scans = subject.scans(work)
    for number, method in enumerate(subject.methods):
        pack = work / f"{method}.facezip"
        words = ("compress", scans, "-o", pack, *METHODS[method])
        # Loads kernels, too, so that it is not timed.
        document = answer(*words)
        row = _row(subject, method, document)
        if number == 0:
            yield _textures(row, document)
        if subject.timed:
            found = cost(partial(answer, *words, "--overwrite"), partial(_pass_images, scans, _images_of(pack), work))
            row = replace(row, cpu=found.ratio, cpu_spread=found.spread)
        yield row


def _textures(row: Row, document: dict[str, Any]) -> Row:
    """The row of every texture as it is, beside one of a pack."""
    return replace(
        row,
        method="textures",
        rmse=0.0,
        bytes_on_gpu=document["bytes_raw"],
        bytes_bc7=document["bytes_raw_bc7"],
        bits=row.bits * document["bytes_raw_bc7"] / document["bytes_bc7"],
        fetches=(1 + row.expressions) * len(document["maps"]),
        command="",
    )


def answer(*words: object) -> dict[str, Any]:
    """What ``facezip`` says to a program, in this process: kernels are loaded once for all."""
    said = io.StringIO()
    with redirect_stdout(said):
        facezip.main([*map(str, words), "--json"], standalone_mode=False)
    found: dict[str, Any] = json.loads(said.getvalue())
    return found


def _images_of(pack: Path) -> dict[str, Texels]:
    return {path.name: read_texture_exactly(path) for path in sorted(pack.glob("*.png"))}


def _pass_images(scans: Path, written: Mapping[str, Texels], work: Path) -> None:
    """What no compressor of textures can avoid: its images read, its own written."""
    for path in sorted(path for path in scans.iterdir() if path.suffix.lower() in TEXTURE_SUFFIXES):
        read_texture(path)
    for name, texels in written.items():
        write_texture(work / name, texels)


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
        versions=versions(),
        inputs=subject.inputs,
        command=" ".join(("compress scans -o me.facezip", *METHODS[method])),
    )
