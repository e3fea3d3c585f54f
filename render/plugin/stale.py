"""References that no test has: their test went, or got another name, or compares no such image any more.

A reference knows the test that made it. It is stale where that test's file was read in full and holds no such test; or
where the file is gone; or where the test passed and never came to it. A test that was deselected, skipped or failed
says nothing of its references, and neither does a file that this run did not read.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from render.plugin.baseline import Baseline
from render.plugin.labels import stem_of
from render.plugin.results import Result, StaleReference
from render.plugin.selection import Selection
from render.plugin.settings import DEFAULT_BASELINE, Settings


def stale_references(
    selection: Selection, results: Sequence[Result], settings: Settings, root: Path, whole: bool
) -> list[StaleReference]:
    """The stale ones of the folders that the tests of a run have their references in.

    Parameters
    ----------
    selection : what the run collected, and what of it passed.
    results : of its images.
    settings : of the run.
    root : the folder that node ids start from.
    whole : whether all tests of the project ran: only then is anything said of references that tests share.
    """
    beside = {(root / file).parent / DEFAULT_BASELINE for file in selection.files}
    folders = {settings.baseline} if settings.baseline else beside
    used = {_image_of(Path(result.reference)) for result in results if result.reference}
    whole = whole and selection.asking <= selection.passed
    return [
        StaleReference(reference=str(baseline.path(name)), test=test)
        for folder in sorted(folders)
        for baseline in [settings.baseline_in(folder)]
        for name, test in _unused(baseline, used)
        if _is_stale(test, selection, root, whole)
    ]


def _image_of(reference: Path) -> tuple[Path, str]:
    return reference.parent, stem_of(reference.name.partition(".exr")[0])


def _unused(baseline: Baseline, used: set[tuple[Path, str]]) -> Iterator[tuple[str, str]]:
    for name in baseline.names():
        if (baseline.folder, stem_of(name)) not in used:
            test = baseline.test_of(name)
            # Others may keep images there that are no references.
            if test is not None:
                yield name, test


def _is_stale(test: str, selection: Selection, root: Path, whole: bool) -> bool:
    if not test:
        return whole
    file = test.partition("::")[0]
    if file in selection.files:
        return test not in selection.tests or test in selection.passed
    return not (root / file).exists()
