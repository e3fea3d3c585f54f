"""The component of Unity exports runs, on as much of Unity as it uses: its fields may be filled in at any time."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facezip.export import TARGETS
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import layered_model
from tests.facezip.export.gains import regions_in

UNITY = Path(__file__).parent / "unity"
NAMES = ('smile "wide"', "clin d'œil", "blink")
MODELS = {
    "manifest": replace(random_model(slots=5, meshes=True), expressions=NAMES),
    "uniform": replace(random_model(weights=(1, 1), meshes=True), expressions=NAMES),
    "tiles": layered_model(tiles=(1001, 1002)),
    "regional": replace(random_model(meshes=True), expressions=NAMES),
    "masked": replace(masked(random_model(slots=5, meshes=True)), expressions=NAMES),
}


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """By scene: what was drawn, which textures the renderer was given, how many are alive, and the warnings."""
    if shutil.which("mcs") is None or shutil.which("mono") is None:
        pytest.skip("Mono is not installed (Debian's mono-mcs)")
    folder = tmp_path_factory.mktemp("unity")
    for name, model in MODELS.items():
        write_pack(model, folder / f"{name}.facezip")
        region = {"region": regions_in(folder)} if name == "regional" else {}
        TARGETS["unity"](folder / f"{name}.facezip", folder / name, **region)
    # The mesh has them in an order of its own, and not all.
    (folder / "shapes").write_text(f"{NAMES[1]}\n{NAMES[0]}\n", encoding="utf-8")
    sources = [*sorted(UNITY.glob("*.cs")), folder / "manifest" / "FaceZipHead.cs"]
    call("mcs", "-warnaserror", "-nowarn:649", f"-out:{folder / 'scenes.exe'}", *sources)
    files = [*(folder / name / "facezip.json" for name in MODELS), folder / "shapes"]
    lines = call("mono", folder / "scenes.exe", *files).splitlines()
    return {scene: parts for scene, *parts in (line.split("|") for line in lines)}


def call(*command):
    done = subprocess.run([*map(str, command)], capture_output=True, encoding="utf-8", check=False, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_weights_are_those_of_the_shapes_by_their_names(scenes):
    drawn, shown, gains, alive, warned = scenes["all at once"]
    assert drawn == "weights_0 5x3 0 0.5 0.25 0;weights_1 5x3 1 0.5 0.25 0"
    assert shown == "_FaceZipWeights0 _FaceZipWeights1"
    assert gains == "_FaceZipGain_albedo 1"
    assert alive == "2"
    assert warned == "FaceZip: head lacks the blend shapes blink"


@pytest.mark.parametrize("last", range(4))
def test_fields_may_be_filled_in_one_after_another(scenes, last):
    assert scenes[f"last {last}"] == scenes["all at once"]


def test_what_is_changed_later_has_effect_and_leaves_nothing_behind(scenes):
    drawn, shown, _, alive, _ = scenes["another manifest"]
    assert (drawn, alive) == ("black 1x1 0 0.5 0.25 0", "1")
    assert shown == "_FaceZipWeights0"
    drawn, _, _, alive, warned = scenes["another mesh"]
    assert (drawn, alive) == ("weights_0 5x3 0 25 0 0;weights_1 5x3 1 25 0 0", "2")
    assert warned.startswith("FaceZip: ears lacks the blend shapes ")
    assert scenes["another shader"] == scenes["all at once"]
    drawn, _, _, alive, warned = scenes["the manifest of all tiles"]
    assert (drawn, alive) == ("", "0")
    assert "take the facezip.json of a tile's folder" in warned
    assert scenes["disabled"] == ["", "", "_FaceZipGain_albedo 1", "0", ""]


def test_gains_turn_maps_expressions_and_regions(scenes):
    """The shapes are at 0.25 and 0.5; the second expression has the first of them."""
    drawn, _, gains, _, _ = scenes["gains"]
    assert drawn == "weights_0 5x3 0 0.5 0.125 0;weights_1 5x3 1 0.5 0.125 0"
    assert gains == "_FaceZipGain_albedo 0.5"
    drawn, _, gains, _, _ = scenes["gains of regions"]
    assert drawn == "weights_0 5x3 0 0.5 0.5 0 2 1 1 regions"
    assert gains == "_FaceZipGain_albedo 2"


def test_masks_are_given_the_activations_of_the_blend(scenes):
    """The shapes are at 0.25 and 0.5; the second expression has the first of them, the third has none."""
    drawn, shown, _, alive, _ = scenes["masks"]
    first, second = drawn.split(";")
    assert (first.split()[:3], second.split()[:3]) == (["masks", "5x3", "0"], ["masks", "5x3", "1"])
    assert (shown, alive) == ("_FaceZipWeights0 _FaceZipWeights1", "2")
    given = np.array([part.split()[3:] for part in (first, second)], np.float32)
    blend = np.array([0.5, 0.25, 0], np.float32)
    activations = MODELS["masked"].masked.activations.astype(np.float32)
    expected = np.einsum("n,nki->ki", blend, activations)
    # Six masks take two fours, five slots two layers.
    np.testing.assert_allclose(given[0].reshape(2, 8, 4)[0, :6], expected[:, :4], atol=1e-6)
    np.testing.assert_allclose(given[1].reshape(2, 8, 4)[1, :6, 0], expected[:, 4], atol=1e-6)
    assert not given.reshape(2, 2, 8, 4)[:, :, 6:].any()
    assert not given.reshape(2, 2, 8, 4)[:, 1, :, 1:].any()


def test_masks_wait_for_their_image(scenes):
    assert scenes["masks without their image"][0] == ""


def test_a_gain_of_nothing_is_warned_of(scenes):
    assert "has nothing called chin" in scenes["a gain of nothing"][-1]


def test_regions_wait_for_their_image(scenes):
    assert scenes["regions without their image"][0] == ""
