"""Tests of the tests: ``python -m tests.mutation [--sample 100] [--seconds 600] [MODULE ...]``.

Each mutant of a module runs the tests of that module until one fails. One that none of them notices gets a test, or a
reason in ``tests/mutation/survivors.toml`` why it changes nothing that is promised. The exit code is 1 where one has
neither.
"""

import argparse
import importlib.abc
import importlib.util
import multiprocessing
import os
import random
import sys
import time
import tomllib
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, ModuleType

import pytest

from tests.mutation.operators import Mutant, mutants

PACK, PLUGIN = Path("tests/facezip/pack"), Path("tests/render/plugin")
# Each module, and the tests that hold it, the quickest first.
TESTS = {
    "facezip.pack.manifest": [PACK / "test_manifest.py", PACK / "test_golden.py", PACK / "test_packs.py"],
    "facezip.pack.verification": [PACK / "test_packs.py"],
    "facezip.pack.quantise": [PACK / "test_quantise.py", PACK / "test_golden.py"],
    "facezip.fit.sweep": [Path("tests/facezip/fit/test_sweep.py")],
    "render.decision": [Path("tests/render/test_decision.py")],
    "render.plugin.statistics": [PLUGIN / "test_statistics.py"],
}
# What the tests import that takes seconds, once for all of them.
SLOW = ("colour", "hypothesis", "matplotlib", "mitsuba", "numba", "OpenImageIO", "scipy.stats", "skimage", "sklearn")
SURVIVORS = Path(__file__).with_name("survivors.toml")
# For the tests of one mutant: some loop for ever.
SECONDS = 240


class Mutated(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one module from a syntax tree, in the place of its file."""

    def __init__(self, name: str, code: CodeType) -> None:
        self.name, self.code = name, code

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        return importlib.util.spec_from_loader(name, self, origin=self.code.co_filename) if name == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        # Where numba looks for the source of its caches, and pytest for that of a traceback.
        module.__file__ = self.code.co_filename
        exec(self.code, module.__dict__)


def _file(module: str) -> Path:
    return Path(*module.split(".")).with_suffix(".py")


def _run(module: str, code: CodeType) -> None:
    """In a child: the exit code is 0 where no test fails."""
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    sys.meta_path.insert(0, Mutated(module, code))
    # Pytest would rewrite the asserts of a plugin's modules, and read their files for that.
    options = ["-x", "-q", "-p", "no:cacheprovider", "--assert=plain"]
    os._exit(pytest.main([*options, *map(str, TESTS[module])]))


def survives(module: str, mutant: Mutant | None) -> bool:
    """Whether all tests of a module pass with a mutant in its place; with None, with the module itself."""
    file = _file(module)
    tree = mutant.tree if mutant else file.read_text(encoding="utf-8")
    child = multiprocessing.get_context("fork").Process(target=_run, args=(module, compile(tree, str(file), "exec")))
    child.start()
    child.join(SECONDS)
    if child.is_alive():
        child.kill()
        child.join()
        return False
    return child.exitcode == 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", default=[*TESTS], help=", ".join(TESTS))
    parser.add_argument("--sample", type=int, help="so many mutants of each module, drawn at random, not all")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="for each module; then it is a sample too")
    options = parser.parse_args()
    for name in SLOW:
        importlib.import_module(name)
    known: dict[str, dict[str, str]] = tomllib.loads(SURVIVORS.read_text(encoding="utf-8"))
    unexplained = 0
    for module in options.modules:
        if not survives(module, None):
            sys.exit(f"{module}: its tests fail without a mutant")
        every = list(mutants(_file(module).read_text(encoding="utf-8")))
        drawn = random.Random(0).sample(
            every, len(every) if options.sample is None else min(options.sample, len(every))
        )
        end, tried, alive = time.monotonic() + options.seconds, 0, []
        for mutant in drawn:
            if time.monotonic() > end:
                break
            tried += 1
            if survives(module, mutant):
                alive.append(mutant)
                reason = known.get(module, {}).get(mutant.name)
                unexplained += reason is None
                print(f"  {_file(module)}:{mutant.line}: {mutant.name}: {reason or 'NOT EXPLAINED'}", flush=True)
        killed = tried - len(alive)
        print(f"{module}: {killed} of {tried} killed, {killed / tried:.0%} ({len(every)} in all)", flush=True)
    sys.exit(1 if unexplained else 0)


if __name__ == "__main__":
    main()
