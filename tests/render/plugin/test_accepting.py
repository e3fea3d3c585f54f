"""What a test may say of how its image is compared: regions, several references, warnings, images that must differ."""

import sys

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import write_texture
from render.plugin.ignoring import ignored_pixels
from render.plugin.labels import accepted, labelled
from render.plugin.reference import Reference
from tests.render.plugin.conftest import BRIGHTER, EQUAL, SIDE, STEM, images_in, renders

CLOCK = """
def test_box(facezip_image):
    def clock(seed):
        image = render(seed, GAIN)
        image[:8, :8] = np.random.default_rng(NOW).random(3)
        return image
    facezip_image(clock, ignore=IGNORE)
"""


def clock(now, ignore="np.s_[:8, :8]", gain=1.0):
    return CLOCK.replace("NOW", str(now)).replace("IGNORE", ignore).replace("GAIN", str(gain))


def test_an_ignored_region_may_differ_and_no_other(project):
    project(clock(0), "--facezip-generate=all")
    project(clock(1)).assert_outcomes(passed=1)
    project(clock(1, gain=1.03)).assert_outcomes(failed=1)
    project(clock(1, "np.s_[:4, :8]")).stdout.fnmatch_lines(["*made without 32 pixels that the test does not ignore*"])
    project(clock(1, "None")).assert_outcomes(failed=1)


def test_a_region_that_is_ignored_later_needs_no_new_reference(project):
    project(clock(0, "None"), "--facezip-generate=all")
    project(clock(1, "None")).assert_outcomes(failed=1)
    project(clock(1)).assert_outcomes(passed=1)
    project(clock(1, gain=1.1)).assert_outcomes(failed=1)


def test_ignored_pixels_count_for_nothing():
    ignored = np.zeros((SIDE, SIDE), bool)
    ignored[10:20, 12:] = True
    reference = Reference.of(renders(range(32)), ignored)
    test = renders(range(40, 48))
    spoilt = np.where(ignored[..., None], 50 * test[::-1] + 3, test)
    expected, found = (reference.compare(stack, ignored) for stack in (test, spoilt))
    assert (expected.probability, expected.statistic) == (found.probability, found.statistic)
    other = renders(range(32))
    other[:, ignored] = 7
    assert Reference.of(other, ignored).spreads == reference.spreads


def test_a_reference_without_a_region_reads_back(tmp_path):
    ignored = np.zeros((SIDE, SIDE), bool)
    ignored[3:5] = True
    reference = Reference.of(renders(range(8)), ignored)
    reference.write(tmp_path / "a.exr", {})
    np.testing.assert_array_equal(Reference.read(tmp_path / "a.exr").ignored, ignored)


@pytest.mark.parametrize("masked", [False, True])
def test_equal_renders_are_alarms_no_more_often_than_promised(masked):
    ignored = np.zeros((SIDE, SIDE), bool)
    ignored[:, : SIDE // 2] = masked
    below = 0
    for trial in range(20):
        first = 100 * trial
        reference = Reference.of(renders(range(first, first + 16)), ignored if masked else None)
        below += reference.compare(renders(range(first + 16, first + 20)), ignored).probability < 0.05
    assert below <= 4


def test_regions_come_as_files_arrays_slices_and_lists(tmp_path):
    expected = np.zeros((8, 6), bool)
    expected[2:4, 1:] = True
    write_texture(tmp_path / "mask.png", np.repeat(255 * expected[..., None].astype(np.uint8), 3, axis=2))
    for region in (tmp_path / "mask.png", str(tmp_path / "mask.png"), expected, 1.0 * expected, np.s_[2:4, 1:]):
        np.testing.assert_array_equal(ignored_pixels(region, (8, 6)), expected)
    np.testing.assert_array_equal(ignored_pixels([np.s_[2, 1:], np.s_[3, 1:]], (8, 6)), expected)
    assert ignored_pixels(None, (8, 6)) is None


@pytest.mark.parametrize(
    ("region", "code"),
    [
        (np.zeros((8, 6)), ErrorCode.BAD_VALUE), (np.ones((8, 6)), ErrorCode.BAD_VALUE), ([], ErrorCode.BAD_VALUE),
        (np.ones((6, 8)), ErrorCode.SIZE_MISMATCH), (np.s_[99, 0], ErrorCode.BAD_VALUE), ({}, ErrorCode.BAD_VALUE),
        ("nowhere.png", ErrorCode.MISSING_FILE),
    ],
)  # fmt: skip
def test_what_is_no_region_is_refused(region, code):
    with pytest.raises(FaceZipError) as caught:
        ignored_pixels(region, (8, 6))
    assert caught.value.code is code


def test_a_reference_of_a_platform_or_variant_stands_in_the_place_of_the_usual_one():
    here = f"a@{sys.platform}"
    names = ["a", here, "a@elsewhere", "a@scalar_rgb", "a+late", "a@scalar_rgb+late", f"{here}+old", "ab", "ab+late"]
    assert accepted(names, "a", "scalar_rgb") == ["a@scalar_rgb", "a@scalar_rgb+late"]
    assert accepted(names, "a", "") == [here, f"{here}+old"]
    assert accepted(names, "a", "llvm_ad_rgb") == [here, f"{here}+old"]
    assert accepted(["a", "a@elsewhere", "a+late"], "a", "") == ["a", "a+late"]
    assert accepted(["a@elsewhere"], "a", "") == []


def test_labels_say_what_a_new_reference_stands_for():
    assert labelled("a", "", "v") == "a"
    assert labelled("a", "platform", "") == f"a@{sys.platform}"
    assert labelled("a+late", "variant", "v") == "a@v"
    with pytest.raises(FaceZipError, match="variant="):
        labelled("a", "variant", "")
    assert labelled("a@v", "late", "v") == "a@v+late"


def test_one_of_several_references_suffices(generated, pytester):
    generated(BRIGHTER).assert_outcomes(failed=1)
    result = generated(BRIGHTER, "--facezip-generate=failed", "--facezip-as", "new-driver")
    result.stdout.fnmatch_lines([f"*{STEM}: added to those that are accepted*"])
    assert {path.name for path in (pytester.path / "baseline").iterdir()} == {f"{STEM}.exr", f"{STEM}+new-driver.exr"}
    generated(BRIGHTER).assert_outcomes(passed=1)
    assert generated(EQUAL).ret == pytest.ExitCode.OK
    result = generated(BRIGHTER.replace("1.03", "1.2"))
    result.stdout.fnmatch_lines(["*nor does it agree with the 1 others*"])


def test_a_platform_has_a_reference_of_its_own(generated, pytester):
    generated(BRIGHTER, "--facezip-generate=failed", "--facezip-as", "platform")
    assert (pytester.path / "baseline" / f"{STEM}@{sys.platform}.exr").is_file()
    generated(BRIGHTER).assert_outcomes(passed=1)
    generated(EQUAL).assert_outcomes(failed=1)


def test_tests_may_share_a_reference(project, pytester):
    shared = "@pytest.mark.parametrize('k', range(3))\ndef test_box(facezip_image, k):\n"
    shared += "    facezip_image(render, reference='box')\n"
    project(shared, "--facezip-generate=all").assert_outcomes(skipped=1, passed=2)
    assert [path.name for path in (pytester.path / "baseline").iterdir()] == ["box.exr"]
    assert project(shared).ret == pytest.ExitCode.OK
    assert project("def test_other(facezip_image): pytest.skip()\n", "test_it.py::test_other").ret == pytest.ExitCode.OK
    result = project(EQUAL, "--facezip-generate=missing")
    result.assert_outcomes(skipped=1)
    result = project(EQUAL)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*box.exr, made by tests that shared it*"])


MUST = "def test_box(facezip_image):\n    facezip_image(render)\n    facezip_image(OTHER, must_differ=True)\n"
SPOILT = MUST.replace("OTHER", "lambda seed: render(seed, 1.03)")


def test_an_image_that_must_differ_fails_where_it_agrees(project, pytester):
    project(SPOILT, "--facezip-generate=all").assert_outcomes(skipped=1)
    assert [path.name for path in (pytester.path / "baseline").iterdir()] == [f"{STEM}.exr"]
    assert project(SPOILT).ret == pytest.ExitCode.OK
    result = project(MUST.replace("OTHER", "lambda seed: render(seed + 50)"))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"*{STEM}.must-differ-2: agrees with its reference, though it must differ: p = *"])
    assert project(SPOILT, "--facezip-generate=failed").ret == pytest.ExitCode.OK
    project(MUST.replace("OTHER", "lambda seed: render(seed)[:8]")).stdout.fnmatch_lines(
        ["*the image has 32 x 8 x 3 *"]
    )


def test_an_image_that_must_differ_needs_a_reference(project):
    alone = "def test_box(facezip_image):\n    facezip_image(render, must_differ=True)\n"
    project(alone).stdout.fnmatch_lines(["*no reference*"])
    project(alone, "--facezip-generate=all").assert_outcomes(skipped=1)


def test_what_is_unlikely_is_listed_and_passes(generated, pytester):
    flags = "--facezip-level", "1e-300", "--facezip-summary", "json,html"
    result = generated(BRIGHTER, *flags, "--facezip-warn", "0.01")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["*1 images pass and are less likely than*", f"*{STEM}: p = *"])
    (told,) = images_in(pytester.path / "facezip-results").results
    assert told.outcome == "warned"
    generated(BRIGHTER, *flags).stdout.no_fnmatch_line("*less likely*")


def test_wrong_flags_stop_the_run(project):
    for flags in (("--facezip-as", "x"), ("--facezip-generate=all", "--facezip-as", "a/b"), ("--facezip-warn", "2")):
        result = project(EQUAL, *flags)
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines(["*ERROR: *facezip*"])
