"""The hooks of the pytest plugin ``facezip``: light, for they are loaded by every run of pytest beside FaceZip."""

import json
from collections.abc import Generator
from typing import TYPE_CHECKING, Any

import pytest

from render.plugin.imports import choose_llvm_in_time
from render.plugin.settings import PROPERTY, Settings, add_options

if TYPE_CHECKING:
    from render.plugin.fixture import ImageCheck

_SETTINGS = pytest.StashKey[Settings]()
_CHECK = pytest.StashKey["ImageCheck"]()
_RESULTS = pytest.StashKey[list[dict[str, Any]]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flags of the plugin; called before any conftest.py, which may import Mitsuba."""
    add_options(parser)
    choose_llvm_in_time()


def pytest_configure(config: pytest.Config) -> None:
    """Check the flags before anything runs."""
    config.stash[_SETTINGS] = Settings.of(config)
    config.stash[_RESULTS] = []
    config.pluginmanager.register(_Collector(config.stash[_RESULTS]), "facezip-results")


@pytest.fixture
def facezip_image(request: pytest.FixtureRequest) -> "ImageCheck":
    """Compare a render with its stored reference, under a test that knows render noise."""
    from render.plugin.fixture import ImageCheck

    check = ImageCheck(request.node, request.config.stash[_SETTINGS])
    request.node.stash[_CHECK] = check
    return check


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
    """A test that generated references compared nothing: it is skipped, not passed."""
    result = yield
    check = pyfuncitem.stash.get(_CHECK, None)
    if check and check.generated:
        pytest.skip(f"generated {', '.join(path.name for path in check.generated)}")
    return result


class _Collector:
    """Gathers results from the reports of tests, in the process that prints them."""

    def __init__(self, results: list[dict[str, Any]]) -> None:
        self._results = results

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take what the fixture noted on a finished test."""
        if report.when == "call":
            self._results += [json.loads(str(value)) for name, value in report.user_properties if name == PROPERTY]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the summaries, once for all workers."""
    settings = session.config.stash[_SETTINGS]
    if settings.summaries and not hasattr(session.config, "workerinput"):
        from render.plugin.summary import write_summaries

        write_summaries(session.config.stash[_RESULTS], settings)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say where generated references, evidence and summaries are."""
    results, settings = config.stash[_RESULTS], config.stash[_SETTINGS]
    generated = sum(result["outcome"] == "generated" for result in results)
    if generated:
        terminalreporter.write_line(f"facezip: {generated} references written to {settings.generate}")
    if any("evidence" in result for result in results) or settings.summaries:
        terminalreporter.write_line(f"facezip: results in {settings.results}")
