"""One run of pytest: its results, and what is wrong with it as a whole."""

from dataclasses import dataclass, field

import pytest

from facezip.documents.document import from_json
from render.plugin.results import Result, StaleReference
from render.plugin.selection import Selection, is_partial
from render.plugin.settings import PROPERTY, Settings


@dataclass(eq=False)
class Run:
    """Gathers results from the reports of tests, in the process that prints them.

    Attributes
    ----------
    settings : of the run.
    selection : what it collected.
    results : of its images, in the order in which they arrived.
    stale : references without a test; see :func:`render.plugin.stale.stale_references`.
    idle : how many tests asked for the fixture, where none compared anything.
    """

    settings: Settings
    selection: Selection = field(default_factory=Selection)
    results: list[Result] = field(default_factory=list)
    stale: list[StaleReference] = field(default_factory=list)
    idle: int = 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take what the fixture noted on a finished test."""
        if report.when == "call":
            noted = (str(value) for name, value in report.user_properties if name == PROPERTY)
            self.results += [from_json(text, Result) for text in noted]

    def judge(self, session: pytest.Session) -> None:
        """Look for what no single test can tell, and fail the run for it."""
        config = session.config
        if session.exitstatus not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED) or is_partial(config):
            return
        if not self.results:
            self.idle = len(self.selection.asking)
        if self._looks_for_stale():
            from render.plugin.stale import stale_references

            whole = config.args_source is not pytest.Config.ArgsSource.ARGS
            self.stale = stale_references(self.selection, self.results, self.settings, config.rootpath, whole)
        if (self.stale or self.idle) and not self.settings.allow_stale and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _looks_for_stale(self) -> bool:
        """New references into a folder of their own are no tests' yet; those of a commit are as they are."""
        return not self.settings.into and not self.settings.commit
