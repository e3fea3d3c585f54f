"""What no single test can tell: references without a test, tests and runs that compared nothing."""

import pytest

from tests.render.plugin.conftest import EQUAL, HEAD, STEM, images_in

FAST = "facezip_image(render, reference_renders=8)"
EQUAL = EQUAL.replace("facezip_image(render)", FAST)
TWO = EQUAL + f"def test_ball(facezip_image):\n    {FAST}\n"
BALL = "test_it.test_ball"
GONE = f"*{BALL}.exr, made by test_it.py::test_ball*"


@pytest.fixture
def two(project):
    """References of two tests."""
    project(TWO, "--facezip-generate", "all").assert_outcomes(skipped=2)
    return project


def test_a_reference_whose_test_went_fails_the_run(two):
    result = two(EQUAL)
    result.assert_outcomes(passed=1)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*a reference has no test*", GONE])


def test_a_suite_without_fault_passes(two):
    result = two(TWO)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*facezip:*")


def test_it_is_listed_and_allowed_if_asked_for(two, pytester):
    result = two(EQUAL, "--facezip-allow-stale")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines([GONE])
    pytester.makeini("[pytest]\nfacezip_allow_stale = true\n")
    assert two(EQUAL).ret == pytest.ExitCode.OK


def test_an_image_that_a_test_compares_no_more_is_stale(project):
    project(
        "def test_sides(facezip_image):\n    for n in ('left', 'right'): facezip_image(render, name=n)\n",
        "--facezip-generate=all",
    )
    result = project("def test_sides(facezip_image):\n    facezip_image(render, name='left')\n")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*test_it.test_sides.right.exr, made by test_it.py::test_sides*"])


@pytest.mark.parametrize(
    "part",
    [
        ("-k", "box"), ("test_it.py::test_box",), ("--deselect", "test_it.py::test_ball"), ("-m", "not slow"),
        ("--collect-only",), ("--setup-plan",),
    ],
)  # fmt: skip
def test_a_part_of_the_tests_says_nothing_of_the_rest(two, pytester, part):
    pytester.makeini("[pytest]\nmarkers = slow\n")
    result = two(TWO.replace("def test_ball", "@pytest.mark.slow\ndef test_ball"), *part)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*facezip:*")


def test_a_stale_reference_shows_beside_deselected_tests(two, pytester):
    pytester.makeini("[pytest]\nmarkers = slow\n")
    slow = "@pytest.mark.slow\ndef test_other(): pass\n"
    result = two(EQUAL + slow, "-m", "not slow")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([GONE])


def test_the_last_failed_alone_say_nothing_of_the_rest(two, pytester):
    broken = TWO + "def test_broken(): assert not {}\n"

    def run(*arguments):
        pytester.makepyfile(test_it=HEAD + broken)
        return pytester.runpytest("-p", "cacheprovider", *arguments)

    run().assert_outcomes(passed=3)
    broken = broken.replace("not {}", "{}")
    run().assert_outcomes(passed=2, failed=1)
    broken = broken.replace("assert {}", "assert not {}")
    assert run("--lf").ret == pytest.ExitCode.OK


def test_another_file_says_nothing_of_references_in_the_same_folder(two, pytester):
    two(TWO)
    pytester.makepyfile(test_other="def test_nothing(): pass\n")
    assert pytester.runpytest("-p", "no:cacheprovider", "test_other.py").ret == pytest.ExitCode.OK


def test_references_of_a_file_that_is_gone_are_stale(two, pytester):
    (pytester.path / "test_it.py").unlink()
    pytester.makepyfile(test_other="def test_nothing(): pass\n")
    result = pytester.runpytest("-p", "no:cacheprovider")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*2 references have no test*"])


@pytest.mark.parametrize(
    "unsure",
    [
        "@pytest.mark.skip\ndef test_ball(facezip_image): facezip_image(render)\n",
        "def test_ball(facezip_image): pytest.skip('not here')\n",
        "@pytest.mark.xfail(strict=True)\ndef test_ball(facezip_image): raise ValueError\n",
    ],
)
def test_a_test_that_did_not_pass_says_nothing_of_its_references(two, unsure):
    assert two(EQUAL + unsure).ret == pytest.ExitCode.OK


def test_a_broken_run_says_nothing(two, pytester):
    result = two(EQUAL + "def test_stop(): pytest.exit('enough')\n")
    result.stdout.no_fnmatch_line("*no test;*")
    two(EQUAL + "import nothing_of_this_name\n").stdout.no_fnmatch_line("*no test;*")


def test_a_module_that_skips_itself_says_nothing(two):
    assert two("pytest.skip('no display', allow_module_level=True)\n" + EQUAL).ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_foreign_files_beside_references_are_nobodys_business(two, pytester):
    from render.exr import write_exr
    from tests.render.plugin.conftest import noisy

    (pytester.path / "baseline" / "photo.exr").write_bytes(b"no image")
    write_exr(pytester.path / "baseline" / "plate.exr", {"rgb": noisy(0)}, {})
    (pytester.path / "baseline" / "figure.png").write_bytes(b"")
    assert two(TWO).ret == pytest.ExitCode.OK


class TestWorkers:
    """Under pytest-xdist, where the process that judges collects nothing itself."""

    @pytest.fixture
    def spread(self, two, pytester):
        pytest.importorskip("xdist")

        def run(body, *arguments):
            pytester.makepyfile(test_it=HEAD + body)
            return pytester.runpytest_subprocess("-p", "no:cacheprovider", "-n2", *arguments)

        return run

    def test_all_is_well(self, spread):
        result = spread(TWO)
        result.assert_outcomes(passed=2)
        assert result.ret == pytest.ExitCode.OK

    def test_a_stale_reference_is_found(self, spread):
        result = spread(EQUAL)
        assert result.ret == pytest.ExitCode.TESTS_FAILED
        result.stdout.fnmatch_lines([GONE])

    def test_a_part_says_nothing(self, spread):
        assert spread(TWO, "-k", "box").ret == pytest.ExitCode.OK
        assert spread(TWO, "test_it.py::test_box").ret == pytest.ExitCode.OK

    def test_a_run_that_compares_nothing_fails(self, spread):
        result = spread("@pytest.mark.skip\n" + EQUAL, "--facezip-baseline", "elsewhere")
        assert result.ret == pytest.ExitCode.TESTS_FAILED
        result.stdout.fnmatch_lines(["*1 test asks for facezip_image, and this run compared nothing*"])

    def test_groups_find_the_same_references(self, spread):
        grouped = "@pytest.mark.xdist_group('one')\n" + EQUAL + TWO[len(EQUAL) :]
        result = spread(grouped, "--dist", "loadgroup")
        result.assert_outcomes(passed=2)
        assert result.ret == pytest.ExitCode.OK


def test_a_test_that_asks_and_compares_nothing_fails(project):
    result = project(EQUAL.replace(FAST, "pass"))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*the test asked for it and compared nothing*"])


def test_a_run_that_compares_nothing_fails(project):
    result = project("@pytest.mark.skip\n" + EQUAL)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*1 test asks for facezip_image, and this run compared nothing*"])
    assert project("@pytest.mark.skip\n" + EQUAL, "--facezip-allow-stale").ret == pytest.ExitCode.OK
    assert project("@pytest.mark.skip\n" + EQUAL, "-k", "box").ret == pytest.ExitCode.OK


def test_a_run_without_image_tests_is_left_alone(project):
    assert project("def test_sum(): assert 1 + 1 == 2\n").ret == pytest.ExitCode.OK


def test_the_document_lists_them(two, pytester):
    two(EQUAL, "--facezip-summary", "json,html")
    document = images_in(pytester.path / "facezip-results")
    (one,) = document.stale
    assert one.test == "test_it.py::test_ball"
    assert one.reference.endswith(f"{BALL}.exr")
    assert document.idle == 0
    assert [result.name for result in document.results] == [STEM]
    assert f"{BALL}.exr" in (pytester.path / "facezip-results" / "index.html").read_text()
