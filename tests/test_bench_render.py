"""``facezip bench render`` and ``bench metrics`` as their users call them; how fast they are is never checked."""

import json

import numpy as np
import pytest

from facezip.character.loading import save_character
from facezip.character.meshes import Meshes
from facezip.character.scans import Stack
from facezip.errors import ExitCode
from render.bench import Pose, render_alone, renderer_of
from render.convergence import bench_metrics
from render.metrics import METRICS
from render.settings import Settings
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS
from tests.facezip.conftest import one_albedo, random_character
from tests.render.conftest import lumpy_head
from tests.test_cli import run


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans") / "sheet"
    save_character(random_character(side=32, expressions=4), folder)
    return folder


def test_ratios_are_those_of_one_run(scans):
    done = run("bench", "render", "--character", scans, "--resolution", 32, "--spp", 4, "--repeats", 2, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    pairs = 2 * 1 * 2 * 2
    assert document["images"] == pairs * 3 // 2
    for timed in (document, *document["runs"]):
        assert timed["speedup"] == pytest.approx(timed["naive_s"] / timed["paired_s"])
        assert timed["pairs_per_second"] == pytest.approx(pairs / timed["paired_s"])
    assert (document["conditions"]["packs"], document["conditions"]["spp"]) == (2, 4)


def test_both_ways_show_the_same_picture(character_on_a_ball):
    character = character_on_a_ball
    settings = Settings(views=VIEWS[:1], lights=("studio",), resolution=32, spp=256)
    naive = render_alone(
        character, character.meshes.vertices[0], character.texture("smile"), VIEWS[0], "studio", settings
    )[..., :3]
    renderer = renderer_of(character, settings)
    renderer.pose(character.meshes.vertices[0])
    paired = renderer.render([upload(SkinMaps(character.texture("smile")))], VIEWS[0], "studio", 256, 0)
    inside = paired.coverage == 1
    assert np.abs(naive[inside] - paired.linear[0][inside]).mean() < 0.06 * naive[inside].mean()


def test_the_same_samples_do_not_deviate_from_themselves(character_on_a_ball):
    """Few samples that are already converged: only the random numbers differ."""
    character = character_on_a_ball
    settings = Settings(views=VIEWS[:1], lights=("studio",), resolution=24, spp=64)
    textures = [character.texture("smile"), np.clip(character.texture("smile") + np.float32(0.05), 0, 1)]
    found = bench_metrics(character, [Pose(character.meshes.vertices[0], textures)], settings, 128).deviation
    assert {*found} == {*METRICS, "image_rmse_debiased", "delta_e_p95_plain"}
    assert all(abs(metric.largest) < 0.05 for metric in found.values())


@pytest.fixture
def character_on_a_ball():
    vertices, topology = lumpy_head()
    rng = np.random.default_rng(0)
    textures = np.kron(rng.integers(60, 200, (3, 8, 8, 3)), np.ones((1, 4, 4, 1))).astype(np.uint8)
    meshes = Meshes(topology, vertices, np.stack([vertices, vertices]))
    return one_albedo(Stack(textures[0], textures[1:]), meshes, ("smile", "frown"))


@pytest.mark.parametrize(
    ("verb", "arguments", "code"),
    [
        ("render", ("--packs", 0), ExitCode.USAGE),
        ("metrics", ("--converged", 100), ExitCode.USAGE),
        ("render", ("--spp", 3), ExitCode.BAD_INPUT),
        ("render", ("--character", "nowhere"), ExitCode.BAD_INPUT),
    ],
)
def test_a_wrong_call_is_one_line(verb, arguments, code):
    done = run("bench", verb, *arguments)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if code is not ExitCode.USAGE:
        assert len(done.stderr.splitlines()) == 1
