"""Readers under libFuzzer, in a process whose facezip tells which branches it takes (:mod:`tests.trust.guided`)."""

import ctypes
import os
import random
import shutil
import sys
import tempfile
from contextlib import AbstractContextManager
from pathlib import Path
from typing import NoReturn

import atheris

ROOT = Path(__file__).parents[2]
# What a module names that has compiled functions, or is one of those that compile.
COMPILED = ("numba", "machine.kernels", "machine.vectors")


def instrumented() -> AbstractContextManager[object]:
    """In the block, modules of facezip are imported with calls that report branches; compiled ones cannot have them."""
    every = {path: path.read_text("utf-8") for path in sorted((ROOT / "facezip").rglob("*.py"))}
    files = [path for path, text in every.items() if any(name in text for name in COMPILED)]
    compiled = [".".join(path.relative_to(ROOT).with_suffix("").parts) for path in files]
    return atheris.instrument_imports(include=["facezip", "tomllib"], exclude=compiled)


def main() -> None:
    """Arguments: readers parted by commas, the folder of the corpus, that of the logs, and libFuzzer's own.

    One reader after the other, each in a fork of a process that has imported and compiled everything.
    """
    names, corpus, logs, *options = sys.argv[1:]
    work = Path(tempfile.mkdtemp())
    with instrumented():
        from tests.trust import fuzz

        every = fuzz.make_corpus(work)
        files = {name: fuzz.different(every[name]) for name in names.split(",")}
        for name, each in files.items():
            for file in each:
                fuzz.finding(name, file)
    for name, each in files.items():
        child = os.fork()
        if child == 0:
            log = os.open(Path(logs) / f"{name}.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(log, 1)
            os.dup2(log, 2)
            arguments = [*options, f"-artifact_prefix={logs}/{name}-", f"{corpus}/{name}"]
            _fuzz(name, each, work / f"{name} seeds", arguments)
        os.waitpid(child, 0)
    shutil.rmtree(work)


def _fuzz(reader: str, files: list[Path], seeds: Path, arguments: list[str]) -> NoReturn:
    """Of libFuzzer's folders the first gets what is new."""
    from tests.trust import fuzz, mutations

    seeds.mkdir()
    for at, file in enumerate(files):
        (seeds / str(at)).write_bytes(bytes([at]) + file.read_bytes())

    def read(data: bytes) -> None:
        if data:
            file, content = fuzz.parted(files, data)
            fault = fuzz.try_bytes(reader, file, content)
            if fault:
                fuzz.keep(f"{reader}-{file.name}", content, fault)

    def mutate(data: bytes, most: int, seed: int) -> bytes:
        """Half of the changes are libFuzzer's, half know of lines, tokens and numbers."""
        rng = random.Random(seed)
        if len(data) < 2 or rng.random() < 0.5:
            return atheris.Mutate(data, most)
        file, content = fuzz.parted(files, data)
        kinds = (*mutations.ALL, *fuzz.TEXTUAL.get(file.suffix, ()))
        return data[:1] + mutations.mutate(rng, content, kinds)[: most - 1]

    # Libraries that end in a fork would wait for threads that it does not have.
    libc = ctypes.CDLL(None)
    libc.on_exit(libc._exit, None)
    atheris.Setup([sys.argv[0], *arguments, str(seeds)], read, custom_mutator=mutate)
    atheris.Fuzz()
    raise SystemExit
