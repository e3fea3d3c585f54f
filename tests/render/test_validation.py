import json

import numpy as np
import pytest

from facezip import FaceZipError
from render.exr import read_exr
from render.validation import Candidate, Settings, validate

FACTS = {"method": "textures", "bytes_on_gpu": 1, "bytes_on_disk": None, "bytes_raw": 1, "fetches": None}
FACTS |= {"texture_rmse": 0.0, "texture_rmse_per_expression": {}}
SMALL = Settings(views=2, lights=2, resolution=48, spp=2)


@pytest.fixture(scope="module")
def result(character, tmp_path_factory):
    folder = tmp_path_factory.mktemp("validation")
    brighter = Candidate("brighter", lambda name: np.clip(character.texture(name) + 0.05, 0, 1), FACTS)
    same = Candidate("same", character.texture, FACTS)
    return validate(character, [same, brighter], folder, SMALL), folder


def test_a_character_against_itself_has_exactly_no_error(result):
    same = result[0]["packs"][0]
    for metric in ("image_rmse", "image_rmse_debiased", "flip", "delta_e_mean", "delta_e_p95"):
        assert same[metric] == 0
    assert same["ssim"] == 1
    assert same["psnr"] is None
    assert same["level"] == "identical"


def test_a_change_is_seen_and_its_worst_render_named(result):
    brighter = result[0]["packs"][1]
    assert brighter["image_rmse"] > 3
    worst = brighter["worst"]["image_rmse"]
    values = [render["packs"][1]["image_rmse"] for render in result[0]["renders"]]
    assert worst["value"] == max(values)
    assert {"expression", "view", "light"} < {*worst}


def test_every_pose_view_and_light_is_rendered_and_kept(result):
    document, folder = result
    assert len(document["renders"]) == 3 * 2 * 2
    for render in document["renders"]:
        parts = read_exr(folder / render["exr"])
        assert list(parts) == ["original", "1 same", "2 brighter"]
        np.testing.assert_array_equal(parts["original"], parts["1 same"])


def test_the_document_is_strict_json_with_its_conditions(result):
    document = json.loads(json.dumps(result[0], allow_nan=False))
    assert document["conditions"]["spp"] == 2
    assert document["conditions"]["llvm"]
    assert document["character"]["expressions"] == ["smile", "frown"]


def test_the_same_run_gives_the_same_numbers(character, result, tmp_path):
    again = validate(character, [Candidate("same", character.texture, FACTS)], tmp_path, SMALL)
    noise = [render["noise_floor"] for render in again["renders"]]
    assert {*noise[0]} >= {"image_rmse", "flip", "delta_e_mean", "delta_e_p95", "ssim"}
    assert noise == [render["noise_floor"] for render in result[0]["renders"]]


@pytest.mark.parametrize(
    "settings", [{"views": 0}, {"lights": 99}, {"spp": 3}, {"resolution": 1}, {"material": "chrome"}, {"seed": -1}]
)
def test_settings_outside_their_range_are_refused(character, tmp_path, settings):
    with pytest.raises(FaceZipError, match=next(iter(settings))):
        validate(character, [], tmp_path, Settings(**settings))
    assert not any(tmp_path.iterdir())
