"""Which references a run writes, and what it says of those that it changes."""

import pytest

from render.plugin.reference import Reference
from tests.render.plugin.conftest import BRIGHTER, EQUAL, STEM, images_in

OTHER = "def test_new(facezip_image):\n    facezip_image(render)\n"


@pytest.fixture
def files(pytester):
    """The bytes of all references by their names."""
    return lambda: {path.stem: path.read_bytes() for path in (pytester.path / "baseline").iterdir()}


def test_missing_ones_alone(generated, files):
    before = files()
    result = generated(BRIGHTER + OTHER, "--facezip-generate=missing")
    result.assert_outcomes(failed=1, skipped=1)
    result.stdout.fnmatch_lines(["*facezip: 1 references written", "*test_it.test_new: new"])
    assert files()[STEM] == before[STEM]
    generated(EQUAL + OTHER).assert_outcomes(passed=2)


def test_those_that_failed_and_missing_ones(generated, files):
    before = files()
    same = EQUAL.replace("test_box", "test_same")
    generated(EQUAL + same, "--facezip-generate=missing")
    kept = files()["test_it.test_same"]
    result = generated(BRIGHTER + same + OTHER, "--facezip-generate=failed")
    result.assert_outcomes(passed=1, skipped=2)
    assert files()["test_it.test_same"] == kept
    assert files()[STEM] != before[STEM]
    generated(BRIGHTER + same + OTHER).assert_outcomes(passed=3)


@pytest.mark.parametrize("mode", ["failed", "all", "baseline"])
def test_a_change_is_listed_with_before_and_after(generated, pytester, mode):
    path = pytester.path / "baseline" / f"{STEM}.exr"
    before = Reference.read(path).mean
    result = generated(BRIGHTER, f"--facezip-generate={mode}", "--facezip-summary=json")
    result.stdout.fnmatch_lines(
        [f"*{STEM}: changed, sha256 * before, * after", "*p = *; most in * before, * after", "*reference is before*"]
    )
    (told,) = images_in(pytester.path / "facezip-results").results
    assert (told.outcome, told.written.change) == ("generated", "changed")
    assert told.written.before != told.written.after
    assert told.comparison.probability < 0.001
    from render.exr import read_exr

    shown = read_exr(pytester.path / "facezip-results" / STEM / "reference.exr")["reference"]
    assert (shown == before).all()
    assert (Reference.read(path).mean != before).any()


def test_what_is_the_same_is_no_change(generated, files):
    before = files()
    result = generated(EQUAL, "--facezip-generate=all")
    result.stdout.fnmatch_lines(["*facezip: 1 references written"])
    result.stdout.no_fnmatch_line(f"*{STEM}: *")
    assert files() == before


def test_another_size_and_a_damaged_file_are_replaced(generated, pytester):
    small = "def test_box(facezip_image):\n    facezip_image(lambda seed: render(seed)[:12])\n"
    generated(small, "--facezip-generate=failed").assert_outcomes(skipped=1)
    generated(small).assert_outcomes(passed=1)
    for mode in ("failed", "all"):
        (pytester.path / "baseline" / f"{STEM}.exr").write_bytes(b"no image")
        result = generated(EQUAL, f"--facezip-generate={mode}")
        result.assert_outcomes(skipped=1)
        result.stdout.fnmatch_lines([f"*{STEM}: changed, *"])
    generated(EQUAL).assert_outcomes(passed=1)
    nothing = EQUAL.replace("(render)", "(lambda seed: None)")
    generated(nothing, "--facezip-generate=failed").assert_outcomes(failed=1)
    generated(EQUAL).assert_outcomes(passed=1)


@pytest.mark.parametrize("mode", ["failed", "all"])
def test_pictures_of_a_failure_go_where_the_new_reference_has_another_size(generated, pytester, mode):
    generated(BRIGHTER).assert_outcomes(failed=1)
    evidence = pytester.path / "facezip-results" / STEM
    assert evidence.is_dir()
    small = "def test_box(facezip_image):\n    facezip_image(lambda seed: render(seed)[:12])\n"
    generated(small, f"--facezip-generate={mode}").assert_outcomes(skipped=1)
    assert not evidence.exists()


def test_a_folder_of_that_name_can_be_meant(project, pytester):
    project(EQUAL, "--facezip-generate", "./all")
    assert (pytester.path / "all" / f"{STEM}.exr").is_file()
