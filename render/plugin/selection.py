"""What a run of pytest collected: which test files in full, which tests, and which of those ask for the fixture."""

from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any

import pytest

FIXTURE = "facezip_image"
# Under which the workers of pytest-xdist send it to the process that they work for.
_OUTPUT = "facezip_selection"
# Options of pytest under which a part of the tests runs, or none.
_PARTS = ("keyword", "lf", "stepwise", "deselect", "collectonly", "setuponly")
# Where a test keeps the node id that it was collected under: `--dist loadgroup` of pytest-xdist adds to it later.
NODE_ID = pytest.StashKey[str]()


@dataclass(eq=False)
class Selection:
    """Filled while pytest collects.

    Attributes
    ----------
    files : node ids of the test files that were read in full, without an error.
    tests : node ids of all tests in them, of those that were deselected later too.
    asking : of the tests that are left, those that ask for the fixture.
    passed : of the tests that are left, those that have passed; filled while they run.
    """

    files: set[str] = field(default_factory=set)
    tests: set[str] = field(default_factory=set)
    asking: set[str] = field(default_factory=set)
    passed: set[str] = field(default_factory=set)

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> Generator[None, Any, Any]:
        """Note a file whose tests are all known."""
        report = yield
        if isinstance(collector, pytest.File) and report.passed:
            self.files.add(collector.nodeid)
        return report

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> Generator[None, Any, Any]:
        """Note the tests before and after some are deselected, by whatever plugin."""
        for item in items:
            item.stash[NODE_ID] = item.nodeid
            self.tests.add(item.nodeid)
        result = yield
        self.asking.update(item.stash[NODE_ID] for item in items if FIXTURE in getattr(item, "fixturenames", ()))
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a test that passed."""
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take what a worker of pytest-xdist collected; they all collect the same."""
        sent = getattr(node, "workeroutput", {}).get(_OUTPUT, {})
        self.files.update(sent.get("files", ()))
        self.tests.update(sent.get("tests", ()))
        self.asking.update(sent.get("asking", ()))

    def send(self, output: dict[str, Any]) -> None:
        """From a worker: put it into what pytest-xdist carries over."""
        output[_OUTPUT] = {"files": [*self.files], "tests": [*self.tests], "asking": [*self.asking]}


def is_partial(config: pytest.Config) -> bool:
    """Whether the caller asked for some tests alone, by their names, by words or as those that failed, or for none.

    What else deselects tests, markers and plugins that share them out, is seen while it does.
    """
    chosen = any("::" in argument for argument in config.args)
    return chosen or any(config.getoption(name, None) for name in _PARTS)
