"""Two writers and a reader at work on one pack: each reading finds one of the two packs, and no mixture."""

import contextlib
import os
import signal
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from facezip import CompressedTextures, FaceZipError
from facezip.pack.read import read_pack
from tests.trust.children import start_child
from tests.trust.findings import Row
from tests.trust.kills import Packs, without_exchange

SECONDS = 60


def check_contention(work: Path, part: float) -> list[Row]:
    """A minute of reading, half of it where names cannot be exchanged."""
    return [
        _row(work / "exchange", "names exchanged", SECONDS * part / 2, exchanging=True),
        _row(work / "renames", "without exchange", SECONDS * part / 2, exchanging=False),
    ]


def _row(work: Path, how: str, seconds: float, exchanging: bool) -> Row:
    packs = Packs(work)
    packs_as_read = []
    for number in (0, 1):
        packs.write(number)
        packs_as_read.append(read_pack(packs.path))
    found: Counter[str] = Counter({"neither of the two": 0, "refused": 0, "other exceptions": 0, "writers ended": 0})
    examples, seen = [], Counter[int]()
    with _writers(packs, exchanging):
        end = time.monotonic() + seconds
        while time.monotonic() < end or (not found.total() and len(seen) < 2 and time.monotonic() < end + SECONDS):
            try:
                held = _which(read_pack(packs.path), packs_as_read)
            except FaceZipError as error:
                found["refused"] += 1
                examples.append(str(error))
            except Exception as error:
                found["other exceptions"] += 1
                examples.append(repr(error))
            else:
                seen[held] += 1
                found["neither of the two"] += held < 0
    ended = sorted(packs.folder.glob("writer_*"))
    found["writers ended"] = len(ended)
    examples += [f"{file.name}: {file.read_text(encoding='utf-8')}" for file in ended]
    notes = f"read {seen[0]} times the one and {seen[1]} times the other"
    return Row(f"reads beside two writers, {how}", seen.total() + found["refused"], found, notes, tuple(examples))


def _which(model: CompressedTextures, known: list[CompressedTextures]) -> int:
    """The number of the pack that this is, all of it; -1 for none."""

    def same(other: CompressedTextures) -> bool:
        return (
            all(
                np.array_equal(part.neutral, other.parts[key].neutral)
                and np.array_equal(part.differences, other.parts[key].differences)
                for key, part in model.parts.items()
            )
            and all(np.array_equal(weights, other.weights[tile]) for tile, weights in model.weights.items())
            and model.meshes is not None
            and other.meshes is not None
            and np.array_equal(model.meshes.vertices, other.meshes.vertices)
        )

    return next((number for number, other in enumerate(known) if same(other)), -1)


@contextlib.contextmanager
def _writers(packs: Packs, exchanging: bool) -> Iterator[None]:
    """Two processes that overwrite the pack for ever, each with its own."""

    def write(number: int) -> None:
        try:
            while True:
                packs.write(number) if exchanging else without_exchange(packs.write, number)
                time.sleep(0.01)
        except BaseException as error:
            packs.path.with_name(f"writer_{number}").write_text(repr(error), encoding="utf-8")
            raise

    writers = [start_child(lambda n=number: write(n)) for number in (0, 1)]
    try:
        yield
    finally:
        for writer in writers:
            with contextlib.suppress(ProcessLookupError, ChildProcessError):
                os.kill(writer, signal.SIGKILL)
                os.waitpid(writer, 0)
