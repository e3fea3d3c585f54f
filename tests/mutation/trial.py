"""Mutants of one module under its tests: collected once, then run in a fork of the process for each mutant."""

import math
import multiprocessing
import os
import resource
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from multiprocessing.connection import Connection
from pathlib import Path
from unittest import mock

import hypothesis
import numba
import pytest

from facezip.machine import kernels
from tests.mutation.operators import Mutant
from tests.mutation.replacing import replace

# Where a mutant waits for ever; one that computes for ever has used up its processor time before.
SECONDS = 900
# Some mutants ask for arrays of any size.
MEMORY = 8 * 2**30
# Pytest would rewrite the asserts of a plugin's modules, and read their files for that.
OPTIONS = ["-q", "-p", "no:cacheprovider", "--assert=plain", "--hypothesis-profile=mutation"]

# Of a mutant: its name, and the test that failed, "" where all passed.
Tell = Callable[[str, str], None]


@dataclass
class Outcome:
    """What the tests said; without words of theirs where a mutant ended the process.

    Attributes
    ----------
    failed : the test, and "" where all passed.
    took : seconds of each test.
    cpu : seconds of processor time of all.
    """

    failed: str = "the process"
    took: dict[str, float] = field(default_factory=dict)
    cpu: float = 0.0


def try_all(module: str, mutants: Sequence[Mutant], tests: Sequence[Path], tell: Tell) -> None:
    """Run the tests of a module for each mutant until one fails."""
    hypothesis.settings.register_profile(
        "mutation", database=None, derandomize=True, phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate]
    )
    said = StringIO()
    with redirect_stdout(said):
        code = pytest.main([*OPTIONS, *map(str, tests)], plugins=[_Trials(module, mutants, tell)])
    if code:
        sys.exit(f"{module}: its tests do not pass without a mutant:\n{said.getvalue()}")


class _Trials:
    """For pytest: forks in the place of a run."""

    def __init__(self, module: str, mutants: Sequence[Mutant], tell: Tell) -> None:
        self.module, self.mutants, self.tell = module, mutants, tell
        self.failed, self.took, self.found = "", Counter[str](), Counter[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.took[report.nodeid] += report.duration
        if report.failed:
            self.failed = report.nodeid

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        if session.testsfailed:
            return None
        itself = self._outcome(session.items, None, 10 * SECONDS)
        if itself.failed or not itself.took:
            session.shouldfail = itself.failed
            raise session.Failed(itself.failed)
        for mutant in self.mutants:
            # Those that found most in the least time come first; others stay beside those of the same fixtures.
            order = sorted(session.items, key=lambda item: self._worth(item.nodeid, itself.took))
            failed = self._outcome(order, mutant, int(5 * itself.cpu) + 20).failed
            self.found[failed] += 1
            self.tell(mutant.name, failed)
        return True

    def _worth(self, test: str, took: dict[str, float]) -> int:
        return round(math.log2(max(took.get(test, 0.0), 0.1) / (1 + self.found[test])))

    def _outcome(self, items: Sequence[pytest.Item], mutant: Mutant | None, cpu: int) -> Outcome:
        ours, theirs = multiprocessing.Pipe(duplex=False)
        with tempfile.TemporaryDirectory() as folder:
            child = multiprocessing.get_context("fork").Process(
                target=self._run, args=(items, mutant, cpu, folder, theirs)
            )
            child.start()
            theirs.close()
            child.join(SECONDS)
            child.kill()
            child.join()
        try:
            return ours.recv()
        except EOFError:
            return Outcome()

    def _run(
        self, items: Sequence[pytest.Item], mutant: Mutant | None, cpu: int, folder: str, result: Connection
    ) -> None:
        os.environ["PYTEST_DEBUG_TEMPROOT"] = folder
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu))
        # Other modules' kernels come from the cache, but none that a mutant's constants are in goes there.
        mock.patch.object(kernels._Cache, "save_overload").start()
        if mutant:
            # Compiling takes longer than what is compiled.
            numba.config.OPT = numba.core.config._OptLevel(0)
            replace(sys.modules[self.module], mutant)
        for item, following in _pairs(items):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self.failed:
                break
        used = resource.getrusage(resource.RUSAGE_SELF)
        result.send(Outcome(self.failed, dict(self.took), used.ru_utime + used.ru_stime))
        os._exit(0)


def _pairs(items: Sequence[pytest.Item]) -> Iterator[tuple[pytest.Item, pytest.Item | None]]:
    yield from zip(items, [*items[1:], None], strict=True)
