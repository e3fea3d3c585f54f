"""The hooks of the pytest plugin ``facezip``: light, for they are loaded by every run of pytest beside FaceZip."""

from collections.abc import Generator, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from render.plugin.imports import choose_llvm_in_time
from render.plugin.matrix import DESCRIPTION, VARIANT, Case, parametrise, under
from render.plugin.run import Run
from render.plugin.settings import Settings, add_options

if TYPE_CHECKING:
    from render.plugin.fixture import ImageCheck

_RUN = pytest.StashKey[Run]()
_SHARED = pytest.StashKey[set[Path]]()
_CHECK = pytest.StashKey["ImageCheck"]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flags of the plugin; called before any conftest.py, which may import Mitsuba."""
    add_options(parser)
    choose_llvm_in_time()


def pytest_configure(config: pytest.Config) -> None:
    """Check the flags before anything runs."""
    run = Run(Settings.of(config))
    config.stash[_RUN], config.stash[_SHARED] = run, set()
    config.addinivalue_line("markers", DESCRIPTION)
    config.pluginmanager.register(run, "facezip-run")
    config.pluginmanager.register(run.selection, "facezip-selection")


@pytest.fixture
def facezip_image(request: pytest.FixtureRequest) -> "ImageCheck":
    """Compare a render with its stored reference, under a test that knows render noise."""
    from render.plugin.fixture import ImageCheck

    check = ImageCheck(request.node, request.config.stash[_RUN].settings, request.config.stash[_SHARED])
    request.node.stash[_CHECK] = check
    return check


@pytest.fixture
def facezip_case(request: pytest.FixtureRequest, facezip_image: "ImageCheck") -> Iterator[Case]:
    """One combination of the marker ``facezip_matrix``: its values, and the comparison with its reference."""
    variant = request.param.names.get(VARIANT)
    with under(variant) if variant else nullcontext():
        yield Case(request.param, request.node, facezip_image)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make a test of each combination of a matrix."""
    parametrise(metafunc)


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
    """A test that compared nothing has not passed: it generated references, or never came to its images."""
    result = yield
    check = pyfuncitem.stash.get(_CHECK, None)
    if check and not check.calls:
        hint = "compare an image, ask for no facezip_image, or skip the test"
        pytest.fail(f"facezip_image: the test asked for it and compared nothing\n  {hint}", pytrace=False)
    if check and check.generated:
        pytest.skip(f"generated {', '.join(path.name for path in check.generated)}")
    if check and not check.compared:
        pytest.skip("generated nothing: an image that must differ has no reference of its own")
    return result


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Judge the run and write the summaries, once for all workers."""
    run = session.config.stash[_RUN]
    if hasattr(session.config, "workeroutput"):
        run.selection.send(session.config.workeroutput)
        return
    run.judge(session)
    if run.settings.summaries or run.settings.markdown:
        from render.plugin.summary import write_summaries

        write_summaries(run)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say what is wrong with the run, what was generated, and where evidence and summaries are."""
    from render.plugin.terminal import report

    report(terminalreporter, config.stash[_RUN])
