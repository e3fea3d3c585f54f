"""The same bytes for the same input, whatever threads, order of files, run and place; nearly so on other processors."""

import os
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from facezip.character.loading import save_character
from facezip.files.images import read_texture
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
# What stands for other processors: the code that Numba makes, the kernels that OpenBLAS and NumPy choose. Vectors of
# another length add up in another order.
NO_AVX512 = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR"
PROCESSORS: dict[str, dict[str, str]] = {
    "this processor": {},
    "Haswell": {
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": "+avx2,+fma",
        "OPENBLAS_CORETYPE": "Haswell",
        "NPY_DISABLE_CPU_FEATURES": NO_AVX512,
    },
    "Zen 2": {
        "NUMBA_CPU_NAME": "znver2",
        "NUMBA_CPU_FEATURES": "+avx2,+fma",
        "OPENBLAS_CORETYPE": "Zen",
        "NPY_DISABLE_CPU_FEATURES": NO_AVX512,
    },
}


@dataclass(frozen=True)
class Run:
    """Threads, order of files (0 for the system's), folder, and kind of processor."""

    threads: int = 2
    order: int = 0
    folder: str = "here"
    processor: str = "this processor"

    def __str__(self) -> str:
        return f"{self.threads} threads in {self.folder} on {self.processor}"


# The first is what all others must equal.
RUNS = [Run(), Run(1, 1), Run(8, 2), Run(), Run(2, 3, "else/where")]
OTHERS = [Run(processor="Haswell"), Run(processor="Zen 2")]
# By how much the mean texel of 255 may differ on another processor.
NEARLY = 0.05


def check_same(work: Path, part: float) -> list[Row]:
    """Packs and the textures read from them; a small ``part`` leaves out what repeats."""
    save_character(random_character(side=96, grid=9, expressions=6), work / "here" / "sheet")
    shutil.copytree(work / "here" / "sheet", work / "else" / "where" / "sheet")
    runs = RUNS if part == 1 else [RUNS[0], Run(8, 2, "else/where")]
    faults, examples, first = {"other bytes": 0}, [], {}
    for number, run in enumerate(runs):
        digests = _digests(work, number, run)
        first = first or digests
        for file in sorted({*first, *digests}):
            if first.get(file) != digests.get(file):
                faults["other bytes"] += 1
                examples.append(f"{file}, order {run.order}, {run}")
    others = [_other_processors(work, len(runs))] if part == 1 else []
    cases = len(first) * (len(runs) - 1)
    notes = f"{len(METHODS)} methods; {', '.join(map(str, runs))}"
    return [Row("files of packs and their textures, made again", cases, faults, notes, tuple(examples)), *others]


def _other_processors(work: Path, runs: int) -> Row:
    """Textures of packs that code for other processors makes, against those of the first run."""
    faults, examples, cases, largest = {"other textures": 0}, [], 0, 0.0
    for number, run in enumerate(OTHERS, runs):
        _digests(work, number, run)
        here = work / run.folder
        for file in sorted((here / "run 0").glob("*/*.png")):
            texture = here / f"run {number}" / file.relative_to(here / "run 0")
            if not texture.parent.name.endswith(".facezip"):
                apart = float(np.abs(read_texture(file).astype(int) - read_texture(texture)).mean())
                cases, largest = cases + 1, max(largest, apart)
                if apart > NEARLY:
                    faults["other textures"] += 1
                    examples.append(f"{file.name}, {run}: {apart:.3f} of 255 in the mean")
    notes = f"{', '.join(run.processor for run in OTHERS)}: at most {largest:.3f} of 255 in the mean"
    return Row("textures of packs that other processors' code makes", cases, faults, notes, tuple(examples))


def _digests(work: Path, number: int, run: Run) -> dict[str, str]:
    """The SHA-256 of every file that a process of its own makes."""
    out = work / run.folder / f"run {number}"
    call = [sys.executable, "-m", "tests.trust.same", run.threads, run.order, work / run.folder / "sheet", out]
    environment = os.environ | dict.fromkeys(LIBRARIES, str(run.threads)) | PROCESSORS[run.processor]
    subprocess.run([*map(str, call)], check=True, env=environment, timeout=600)
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
