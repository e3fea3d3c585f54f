"""Mutants of one module under its tests: collected once, then run in a fork of the process for each mutant."""

import faulthandler
import math
import multiprocessing
import os
import resource
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from io import StringIO
from multiprocessing.connection import Connection
from tempfile import TemporaryDirectory
from time import process_time
from unittest import mock

import hypothesis
import numba
import OpenImageIO
import pytest

from facezip.machine import kernels
from tests.mutation.operators import Mutant
from tests.mutation.replacing import compile_here, replace

# Where a mutant waits for ever; one that computes for ever has used up its processor time before.
SECONDS = 900
# Some mutants ask for arrays of any size.
MEMORY = 8 * 2**30
# Pytest would rewrite the asserts of a plugin's modules, and read their files for that.
OPTIONS = ["-q", "-p", "no:cacheprovider", "--assert=plain", "--hypothesis-profile=mutation"]
OPTIONS += ["--override-ini=tmp_path_retention_policy=none"]

# Of a mutant: its name, and the test that failed, "" where all passed.
Tell = Callable[[str, str], None]


def try_all(module: str, mutants: Sequence[Mutant], tests: Sequence[str], tell: Tell) -> None:
    """Run the tests of a module for each mutant until one fails."""
    hypothesis.settings.register_profile(
        "mutation", database=None, derandomize=True, phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate]
    )
    said = StringIO()
    # Compiling takes longer than what is compiled. What reads beside an array would fail at times.
    numba.config.OPT, numba.config.BOUNDSCHECK = numba.core.config._OptLevel(0), 1
    # Its threads are not in a fork, and are waited for there.
    OpenImageIO.attribute("threads", 1)
    # Kernels come from the cache, but none that is compiled so, or of a mutant, goes there.
    unsaved = mock.patch.object(kernels._Cache, "save_overload")
    with redirect_stdout(said), unsaved, TemporaryDirectory() as folder:
        options = [*OPTIONS, f"--basetemp={folder}/tests", *tests]
        code = pytest.main(options, plugins=[_Trials(module, mutants, tell)])
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
        compile_here(sys.modules[self.module])
        # Of the module itself, in this process: what its tests load and compile is there for all forks.
        self._run(session.items)
        if self.failed:
            raise session.Failed(self.failed)
        took, cpu = self.took.copy(), int(5 * process_time()) + 20
        for mutant in self.mutants:
            # Those that found most in the least time come first; others stay beside those of the same fixtures.
            order = sorted(session.items, key=lambda item: self._worth(took[item.nodeid], self.found[item.nodeid]))
            failed = self._fork(order, mutant, cpu)
            self.found[failed] += 1
            self.tell(mutant.name, failed)
        return True

    @staticmethod
    def _worth(took: float, found: int) -> int:
        return round(math.log2(max(took, 0.1) / (1 + found)))

    def _fork(self, items: Sequence[pytest.Item], mutant: Mutant, cpu: int) -> str:
        """The test that fails."""
        ours, theirs = multiprocessing.Pipe(duplex=False)
        fork = multiprocessing.get_context("fork")
        child = fork.Process(target=self._run_mutated, args=(items, mutant, cpu, theirs))
        child.start()
        theirs.close()
        child.join(SECONDS)
        child.kill()
        child.join()
        try:
            return str(ours.recv())
        except EOFError:
            return "the process"

    def _run_mutated(self, items: Sequence[pytest.Item], mutant: Mutant, cpu: int, failed: Connection) -> None:
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu))
        replace(sys.modules[self.module], mutant)
        self._run(items)
        failed.send(self.failed)
        os._exit(0)

    def _run(self, items: Sequence[pytest.Item]) -> None:
        """Until one fails."""
        for item, following in zip(items, [*items[1:], None], strict=True):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self.failed:
                break
