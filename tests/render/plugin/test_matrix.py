"""One test over a matrix."""

import pytest

from render.plugin.matrix import choices
from tests.render.plugin.test_plugin import run_apart


def test_every_combination_is_there_once():
    found = choices(variant=["a", "b"], light={"sky": 1, "spot": 2}, agree="variant")
    assert [choice.label for choice in found] == ["a-sky", "a-spot", "b-sky", "b-spot"]
    assert [choice.own for choice in found] == ["sky", "spot", "sky", "spot"]
    assert [choice.values["light"] for choice in found] == [1, 2, 1, 2]


@pytest.mark.parametrize("axes", [{}, {"light": []}, {"light": ["sky"], "agree": "variant"}])
def test_a_matrix_that_makes_no_sense_is_refused(axes):
    with pytest.raises(pytest.UsageError, match="facezip_matrix"):
        choices(**axes)


def test_cases_have_references_of_their_own_or_share_them(project, pytester):
    body = """
@pytest.mark.facezip_matrix(side=["left", "right"], gain={"dim": 1.0, "bright": SECOND}, agree=AGREE)
def test_box(facezip_case):
    assert facezip_case["side"] in ("left", "right")
    facezip_case(lambda seed: render(seed, facezip_case["gain"]), reference_renders=8)
"""
    own = body.replace("SECOND", "1.2").replace("AGREE", "()")
    project(own, "--strict-markers", "--facezip-generate=all").assert_outcomes(skipped=4)
    assert len([*(pytester.path / "baseline").iterdir()]) == 4
    assert "test_it.test_box.left-dim.exr" in {path.name for path in (pytester.path / "baseline").iterdir()}
    project(own).assert_outcomes(passed=4)
    shared = body.replace("SECOND", "1.0").replace("AGREE", "('side', 'gain')")
    arguments = ("--facezip-baseline", "one")
    project(shared, "--facezip-generate=all", *arguments).assert_outcomes(skipped=1, passed=3)
    assert [path.name for path in (pytester.path / "one").iterdir()] == ["test_it.test_box.exr"]
    project(shared.replace('"bright": 1.0', '"bright": 1.2'), *arguments).assert_outcomes(passed=2, failed=2)


def test_a_case_needs_its_marker(project):
    result = project("def test_box(facezip_case): pass\n")
    result.stdout.fnmatch_lines(["*facezip_case needs the marker facezip_matrix*"])


MATRIX = """
import pytest

@pytest.mark.facezip_matrix(
    variant=["scalar_rgb", "llvm_ad_rgb", "scalar_spectral", "no_such_variant"],
    integrator=["direct", "path"],
    light={"sky": {"type": "constant"}, "point": {"type": "point", "position": [0, 2, 0]}},
    agree=("variant", "integrator"),
)
def test_ball(facezip_case):
    film = {"type": "hdrfilm", "width": 12, "height": 12, "pixel_format": "rgb"}
    light = dict(facezip_case["light"])
    if light["type"] == "point":
        light["intensity"] = {"type": "rgb", "value": BRIGHTNESS}
    facezip_case({
        "type": "scene",
        "integrator": {"type": facezip_case["integrator"]},
        "ball": {"type": "sphere", "center": [0, 0, 3], "radius": 0.8, "bsdf": {"type": "diffuse"}},
        "light": light,
        "camera": {"type": "orthographic", "film": film},
    }, spp=16, reference_renders=16)
"""


def test_variants_and_integrators_agree_under_every_light(pytester):
    """A convex body sees no light of its own; rgb variants compute one integral, a spectral one has other noise."""
    bright = MATRIX.replace("BRIGHTNESS", "20.0")
    result = run_apart(pytester, bright, "--facezip-generate=all")
    result.assert_outcomes(skipped=2 + 4, passed=8, failed=2)
    result.stdout.fnmatch_lines(["*if that is meant: *scalar_spectral-direct-sky* --facezip-as variant"])
    spectral = ("-k", "spectral", "--facezip-generate=failed", "--facezip-as=variant")
    run_apart(pytester, bright, *spectral).assert_outcomes(skipped=1, passed=3, deselected=12)
    names = {f"test_it.test_ball.{name}.exr" for name in ("sky", "point", "sky@scalar_spectral")}
    assert {path.name for path in (pytester.path / "baseline").iterdir()} == names
    odd = MATRIX.replace("BRIGHTNESS", "20.0 if facezip_case['variant'] != 'llvm_ad_rgb' else 30.0")
    run_apart(pytester, odd).assert_outcomes(skipped=4, passed=10, failed=2)
