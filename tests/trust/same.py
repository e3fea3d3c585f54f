"""The same bytes for the same input: whatever the threads, the order of a folder's files, the run and the place."""

import os
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

from facezip.character.loading import save_character
from facezip.machine.cores import use_cores
from tests.facezip.conftest import random_character
from tests.trust.findings import Row

METHODS = {
    "refined": (),
    "paper": ("--method", "paper", "--masks", "6", "--restarts", "3"),
    "pca": ("--method", "pca"),
    "masks": ("--method", "masks", "--masks", "6"),
}
LIBRARIES = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# Threads, order of files (0 for the system's), and folder of each run. The first is what all others must equal.
RUNS = [(2, 0, "here"), (1, 1, "here"), (8, 2, "here"), (2, 0, "here"), (2, 3, "else/where")]


def check_same(work: Path, part: float) -> list[Row]:
    """Packs and the textures read from them; a small ``part`` leaves out what repeats."""
    save_character(random_character(side=96, grid=9, expressions=6), work / "here" / "sheet")
    shutil.copytree(work / "here" / "sheet", work / "else" / "where" / "sheet")
    runs = RUNS if part == 1 else [RUNS[0], (8, 2, "else/where")]
    faults, examples, first = {"other bytes": 0}, [], {}
    for number, (threads, order, folder) in enumerate(runs):
        digests = _digests(work, number, threads, order, folder)
        first = first or digests
        for file in sorted({*first, *digests}):
            if first.get(file) != digests.get(file):
                faults["other bytes"] += 1
                examples.append(f"{file} with {threads} threads, order {order}, in {folder}")
    cases = len(first) * (len(runs) - 1)
    notes = f"{len(METHODS)} methods; {', '.join(f'{t} threads in {f}' for t, _, f in runs)}"
    return [Row("files of packs and their textures, made again", cases, faults, notes, tuple(examples))]


def _digests(work: Path, number: int, threads: int, order: int, folder: str) -> dict[str, str]:
    """The SHA-256 of every file that a process of its own makes."""
    out = work / folder / f"run {number}"
    call = [sys.executable, "-m", "tests.trust.same", threads, order, work / folder / "sheet", out]
    environment = os.environ | dict.fromkeys(LIBRARIES, str(threads))
    subprocess.run([*map(str, call)], check=True, env=environment, timeout=300)
    return {str(f.relative_to(out)): sha256(f.read_bytes()).hexdigest() for f in out.rglob("*") if f.is_file()}


def _run(threads: int, order: int, scans: Path, out: Path) -> None:
    from tests.trust.children import command

    use_cores(threads)
    if order:
        rng = random.Random(order)
        Path.iterdir, Path.glob = _shuffled(Path.iterdir, rng), _shuffled(Path.glob, rng)
    out.mkdir(parents=True)
    for method, options in METHODS.items():
        for arguments in (
            ["compress", scans, "-o", out / f"{method}.facezip", *options],
            ["decompress", out / f"{method}.facezip", "-o", out / method],
        ):
            if command(arguments, scans.parent / "messages"):
                raise RuntimeError((scans.parent / "messages").read_text(encoding="utf-8"))


def _shuffled(plain: Callable[..., Any], rng: random.Random) -> Callable[..., Any]:
    def listing(folder: Path, *arguments: Any) -> Any:
        found = list(plain(folder, *arguments))
        return iter(rng.sample(found, len(found)))

    return listing


if __name__ == "__main__":
    _run(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]), Path(sys.argv[4]))
