"""The plugin as the tests of another repository use it."""

import re

import numpy as np
import pytest

from facezip.files.images import read_texture
from render.exr import read_exr
from render.plugin.reference import Reference
from tests.render.plugin.conftest import BRIGHTER, EQUAL, STEM, images_in


def test_equal_renders_pass_and_leave_nothing(generated, pytester):
    before = (pytester.path / "baseline" / f"{STEM}.exr").read_bytes()
    generated(EQUAL).assert_outcomes(passed=1)
    assert (pytester.path / "baseline" / f"{STEM}.exr").read_bytes() == before
    assert not (pytester.path / "facezip-results").exists()


def test_one_image_of_the_caller_passes_as_well(generated):
    generated("def test_box(facezip_image):\n    facezip_image(render(7))\n").assert_outcomes(passed=1)


def test_a_defect_fails_with_evidence_and_the_way_out(generated, pytester):
    before = (pytester.path / "baseline" / f"{STEM}.exr").read_bytes()
    result = generated(BRIGHTER)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([
        f"*{STEM}: differs from its reference by more than noise: p = *, level 0.001",
        "*worst * row *, column *: * instead of *, * standard errors",
        "*reference *baseline*.exr",
        "*evidence *facezip-results*",
        "*pytest test_it.py::test_box --facezip-generate *baseline*",
    ])  # fmt: skip
    result.stdout.no_fnmatch_line("*Traceback*")
    folder = pytester.path / "facezip-results" / STEM
    reference = Reference.read(pytester.path / "baseline" / f"{STEM}.exr")
    parts = {name: read_exr(folder / f"{name}.exr") for name in ("image", "reference", "error", "p_value")}
    np.testing.assert_array_equal(parts["reference"]["reference"], reference.mean)
    image, error = parts["image"]["image"], parts["error"]["error"]
    np.testing.assert_allclose(error, image - reference.mean, atol=2e-3)
    assert parts["p_value"]["16 px"][4:20, 4:28].min() < 1e-3
    assert parts["p_value"]["1 px"][0, 0, 0] == 1
    for name in parts:
        assert read_texture(folder / f"{name}.png").shape == (192, 256, 3)
    assert (pytester.path / "baseline" / f"{STEM}.exr").read_bytes() == before


def test_evidence_goes_when_the_test_passes_again(generated, pytester):
    generated(BRIGHTER)
    generated(EQUAL).assert_outcomes(passed=1)
    assert not (pytester.path / "facezip-results" / STEM).exists()


def test_a_missing_reference_says_how_to_make_it(project):
    result = project(EQUAL)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [f"*{STEM}: no reference *baseline*", "*pytest test_it.py::test_box --facezip-generate *"]
    )


def test_folders_and_level_come_from_flags_or_the_configuration(project, pytester):
    pytester.makeini("[pytest]\nfacezip_baseline = stored\nfacezip_results = out\nfacezip_level = 1e-300\n")
    project(EQUAL, "--facezip-generate", "stored")
    project(BRIGHTER).assert_outcomes(passed=1)
    project(BRIGHTER, "--facezip-level", "0.01").assert_outcomes(failed=1)
    assert (pytester.path / "out" / STEM).is_dir()
    project(EQUAL, "--facezip-baseline", "elsewhere").assert_outcomes(failed=1)


@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("    facezip_image(render(0)[:8])\n", "*the image has 32 x 8 x 3 pixels, its reference 32 x 24 x 3*"),
        ("    facezip_image(render(0) / 0)\n", "*are NaN or infinite, the first at row 0, column 0*"),
        ("    facezip_image(np.zeros(4))\n", "*an image is (H, W)*not (4,)*"),
        ("    facezip_image(render); facezip_image(render)\n", "*a second image '' in one test*"),
    ],
)
def test_a_wrong_image_is_one_line(generated, body, line):
    mark = "@pytest.mark.filterwarnings('ignore:.*encountered')\n"
    result = generated(f"{mark}def test_box(facezip_image):\n{body}")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([line])


def test_a_damaged_reference_is_one_line(generated, pytester):
    (pytester.path / "baseline" / f"{STEM}.exr").write_bytes(b"no image")
    result = generated(EQUAL)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*not a readable OpenEXR file*"])


def test_one_image_is_too_little_for_a_reference(project, pytester):
    result = project("def test_box(facezip_image):\n    facezip_image(render(0))\n", "--facezip-generate", "baseline")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*at least 8 independent renders*"])
    assert not (pytester.path / "baseline").exists()


def test_a_wrong_flag_stops_the_run(project):
    for flag in (("--facezip-summary", "pdf"), ("--facezip-level", "2")):
        result = project(EQUAL, *flag)
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines(["*ERROR: *facezip*"])


HOSTILE = """
@pytest.mark.parametrize("text", ["<script>document.title='owned'</script>", "../../up", "\\u00e9 \\u2603", "CON"])
def test_named(facezip_image, text):
    facezip_image(lambda seed: render(seed, 1.0 if text == "CON" else GAIN))
"""


def test_summaries_hold_every_result_and_run_no_name(project, pytester):
    project(HOSTILE.replace("GAIN", "1.0"), "--facezip-generate", "baseline").assert_outcomes(skipped=4)
    result = project(HOSTILE.replace("GAIN", "1.05"), "--facezip-summary", "html,json", "--facezip-results", "out")
    result.assert_outcomes(passed=1, failed=3)
    results = images_in(pytester.path / "out").results
    assert [one.outcome for one in results].count("failed") == 3
    assert all(re.fullmatch(r"[A-Za-z0-9_.-]+", one.name) for one in results)
    page = (pytester.path / "out" / "index.html").read_text(encoding="utf-8")
    assert page.count("<script>") == 1
    assert "&lt;script&gt;" in page
    assert page.count("data:image/png;base64,") == 16
    assert "3 of 4 differ" in page
    folders = {path.name for path in (pytester.path / "out").iterdir()}
    assert folders == {"index.html", "results.json", *(one.name for one in results)}


def test_a_scene_is_rendered(pytester):
    scene = """
import pytest

@pytest.mark.parametrize(("name", "radius"), [("same", 0.7), ("other", OTHER)], ids=["same", "other"])
def test_ball(facezip_image, name, radius):
    film = {"type": "hdrfilm", "width": 16, "height": 16, "pixel_format": "rgb"}
    facezip_image({
        "type": "scene",
        "integrator": {"type": "path"},
        "ball": {"type": "sphere", "radius": radius, "bsdf": {"type": "diffuse"}},
        "light": {"type": "constant"},
        "camera": {"type": "orthographic", "film": film, "sampler": {"type": "independent"}},
    }, spp=4, reference_renders=8)
"""

    def run(radius, *arguments):
        # Mitsuba lives once in a process.
        pytester.makepyfile(test_it=scene.replace("OTHER", radius))
        return pytester.runpytest_subprocess("-p", "no:cacheprovider", *arguments)

    run("0.7", "--facezip-generate", "baseline").assert_outcomes(skipped=2)
    run("0.6").assert_outcomes(passed=1, failed=1)
    mean = Reference.read(pytester.path / "baseline" / "test_it.test_ball.same.exr").mean
    assert mean.shape == (16, 16, 3)
    assert mean.mean() > 0.1


LOADED = """
import mitsuba as mi

def test_ball(facezip_image):
    mi.set_variant("scalar_rgb")
    film = {"type": "hdrfilm", "width": 16, "height": 16, "pixel_format": "rgb"}
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path"},
        "ball": {"type": "sphere", "bsdf": {"type": "diffuse"}},
        "light": {"type": "constant"},
        "camera": {"type": "orthographic", "film": film},
    })
    facezip_image(scene, spp=4, reference_renders=8)
"""


def run_apart(pytester, body, *arguments):
    """Run a test file where Mitsuba has not been imported yet."""
    pytester.makepyfile(test_it=body)
    return pytester.runpytest_subprocess("-p", "no:cacheprovider", *arguments)


def test_a_loaded_scene_is_rendered(pytester):
    run_apart(pytester, LOADED, "--facezip-generate", "baseline").assert_outcomes(skipped=1)
    run_apart(pytester, LOADED).assert_outcomes(passed=1)


@pytest.mark.parametrize("value", ["'a.exr'", "[object()]", "object()", "[{'type': 'scene'}]", "lambda seed: {}"])
def test_what_is_no_image_is_one_line(generated, value):
    result = generated(f"def test_box(facezip_image):\n    facezip_image({value})\n")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*an image is an array of numbers, not *hand over the dict*"])


CHOSEN = """
import drjit

def test_version():
    assert drjit.detail.llvm_version()[0] >= 17
"""


@pytest.mark.parametrize("early", ["test", "conftest"])
def test_dr_jit_imported_by_a_test_has_an_llvm_that_does_not_abort(pytester, monkeypatch, early):
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    if early == "conftest":
        pytester.makeconftest("import drjit")
    run_apart(pytester, CHOSEN).assert_outcomes(passed=1)


def test_a_library_that_would_abort_is_no_choice(pytester, monkeypatch):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "/nowhere/libLLVM.so")
    run_apart(pytester, CHOSEN).assert_outcomes(passed=1)


def test_loading_the_plugin_imports_no_renderer(pytester):
    pytester.makepyfile(
        "import sys\ndef test_light():\n    assert not {'mitsuba', 'numba', 'numpy'} & {*sys.modules}\n"
    )
    pytester.runpytest_subprocess("-p", "no:hypothesispytest").assert_outcomes(passed=1)
