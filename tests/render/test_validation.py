import json
import threading
from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.maps import KNOWN
from facezip.character.scans import Stack
from facezip.character.tiles import FIRST_TILE
from facezip.documents.document import to_json
from facezip.pack.errors import MapErrors
from render import validation
from render.documents.judged import TextureFacts
from render.exr import read_exr
from render.limits import Limit, Thresholds
from render.settings import Settings
from render.skins import SkinMaps
from render.staging import staged_original
from render.store import RENDERS
from render.validation import Candidate, Filler
from scenes.cameras import VIEWS

FACTS = TextureFacts(bytes_on_gpu=1, bytes_on_disk=None, bytes_raw=1, fetches=None, bytes_bc7=1, bytes_raw_bc7=1)
ERRORS = {"albedo": MapErrors(rmse=0.0, rmse_per_expression={})}
SMALL = Settings(resolution=48, spp=2, max_spp=2)


def validate(*given):
    """The document as it is written."""
    return json.loads(to_json(validation.validate(*given)))


def same(character):
    return Candidate("same", lambda name: SkinMaps(character.texture(name)), FACTS, ERRORS)


def brighter(character, amount):
    return Candidate("brighter", lambda name: SkinMaps(character.texture(name) + np.float32(amount)), FACTS, ERRORS)


@pytest.fixture(scope="module")
def result(character, tmp_path_factory):
    folder = tmp_path_factory.mktemp("validation")
    return validate(character, [same(character), brighter(character, 0.05)], folder, SMALL), folder


def assert_identical(pack):
    for metric in ("image_rmse", "image_rmse_debiased", "flip", "delta_e_mean", "delta_e_p95"):
        assert pack[metric] == 0
    assert pack["ssim"] == 1
    assert pack["psnr"] is None
    assert pack["level"] == "identical"


def test_a_character_against_itself_has_exactly_no_error(result):
    assert_identical(result[0]["packs"][0])


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
    document = result[0]
    assert document["conditions"]["spp"] == 2
    assert document["conditions"]["llvm"]
    assert document["character"]["expressions"] == ["smile", "frown"]


def test_the_same_run_gives_the_same_numbers(character, result, tmp_path):
    again = validate(character, [same(character)], tmp_path, SMALL)
    noise = [render["noise_floor"] for render in again["renders"]]
    assert {*noise[0]} >= {"image_rmse", "flip", "delta_e_mean", "delta_e_p95", "ssim"}
    assert noise == [render["noise_floor"] for render in result[0]["renders"]]


@pytest.mark.parametrize(
    "settings", [{"spp": 3}, {"resolution": 1}, {"material": "chrome"}, {"seed": -1}, {"views": ()}]
)
def test_settings_outside_their_range_are_refused(character, tmp_path, settings):
    with pytest.raises(FaceZipError, match=next(iter(settings))):
        validate(character, [], tmp_path, Settings(**settings))
    assert not any(tmp_path.iterdir())


def test_resolved_settings_and_versions_are_in_the_result(result):
    conditions = result[0]["conditions"]
    assert [view["name"] for view in conditions["views"]] == [view.name for view in VIEWS[:2]]
    assert conditions["views"][0]["azimuth"] == VIEWS[0].azimuth
    assert conditions["lights"] == ["studio", "side"]
    assert conditions["thresholds"]["indistinguishable"] == {"delta_e": 1.0, "flip": 0.05, "local": 2.0}
    assert {"transport", "material", "max_spp", "mitsuba", "pixels_per_degree"} < {*conditions}


def one_look(limits, **changes):
    sizes = {"resolution": 48, "spp": 4, "max_spp": 16, "views": VIEWS[:1], "lights": ("studio",)}
    return Settings(**{**sizes, "thresholds": limits, **changes})


def test_samples_are_spent_only_where_a_limit_is_near(character, tmp_path):
    far = validate(
        character,
        [brighter(character, 0.02)],
        tmp_path / "far",
        one_look(Thresholds(Limit(20, 99, 1), Limit(50, 99, 1))),
    )
    value = far["renders"][0]["packs"][0]["delta_e_p95"]
    near = Thresholds(Limit(value, 99, 1), Limit(50, 99, 1))
    close = validate(character, [brighter(character, 0.02)], tmp_path / "close", one_look(near))
    assert far["renders"][0]["spp"] == 4
    assert far["packs"][0]["decided"]
    assert close["renders"][0]["spp"] > 4


def files_of(folder):
    return {path.name: path.read_bytes() for path in (folder / RENDERS).iterdir()}


@pytest.fixture(scope="module")
def finished(character, tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    settings = one_look(Thresholds(), lights=("studio", "side"))
    return validate(character, [brighter(character, 0.02)], folder, settings), folder, settings


def unlike_in_time(document):
    return {key: value for key, value in document.items() if key not in ("seconds", "pairs_per_second", "rendered")}


def test_only_what_is_missing_is_rendered_and_ends_in_the_same_numbers(character, finished, tmp_path):
    document, folder, settings = finished
    before = files_of(folder)
    for name in ("smile.front.side.json", "frown.front.studio.exr"):
        (folder / RENDERS / name).unlink()
    path = folder / RENDERS / "neutral.front.studio.exr"
    path.write_bytes(path.read_bytes()[:100])
    again = validate(character, [brighter(character, 0.02)], folder, settings)
    assert again["rendered"] == 3
    assert unlike_in_time(again) == unlike_in_time(document)
    assert files_of(folder) == before


def test_a_changed_candidate_renders_only_what_it_changes(character, finished, tmp_path):
    document, folder, settings = finished

    def texture(name):
        return SkinMaps(character.texture(name) + np.float32(0.05 if name == "smile" else 0.02))

    changed = validate(character, [Candidate("brighter", texture, FACTS, ERRORS)], tmp_path, settings, folder)
    assert changed["rendered"] == 2
    same = [r["packs"] for r in document["renders"] if r["expression"] != "smile"]
    assert [r["packs"] for r in changed["renders"] if r["expression"] != "smile"] == same


def test_a_changed_mesh_renders_its_expression_again(character, finished, tmp_path):
    _, folder, settings = finished
    vertices = character.meshes.vertices.copy()
    vertices[character.index("smile"), 0] += np.float32(1e-3)
    moved = replace(character, meshes=replace(character.meshes, vertices=vertices))
    assert validate(moved, [brighter(moved, 0.02)], tmp_path, settings, folder)["rendered"] == 2
    # The camera stands where the neutral asks for it: everything is seen anew.
    larger = replace(character.meshes, neutral=character.meshes.neutral * np.float32(1.001))
    moved = replace(character, meshes=larger)
    assert validate(moved, [brighter(moved, 0.02)], tmp_path / "all", settings, folder)["rendered"] == 6


def test_a_changed_uv_layout_reuses_nothing(character, finished, tmp_path):
    _, folder, settings = finished
    layout = replace(character.meshes.topology, uv=character.meshes.topology.uv * np.float32(0.999))
    moved = replace(character, meshes=replace(character.meshes, topology=layout))
    assert validate(moved, [brighter(moved, 0.02)], tmp_path, settings, folder)["rendered"] == 6


def with_maps(character, **maps):
    """The character with further maps, the same of every expression."""
    stacks = dict(character.stacks)
    for name, values in maps.items():
        texels = KNOWN[name].encode(values)
        stacks[name, FIRST_TILE] = Stack(texels, np.stack([texels] * len(character.expressions)))
    return replace(character, maps=(*character.maps, *(KNOWN[name] for name in maps)), stacks=stacks)


def test_a_skin_of_all_maps_against_itself_has_exactly_no_error(character, tmp_path):
    rng = np.random.default_rng(0)
    normal = rng.normal(0, 0.2, (64, 64, 3)).astype(np.float32) + np.array([0, 0, 1], np.float32)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    numbers = {name: rng.random((64, 64, 1), np.float32) for name in ("roughness", "specular", "cavity")}
    every, flat = with_maps(character, normal=normal, **numbers), with_maps(character, **numbers)
    candidates = [
        Candidate(name, staged_original(scans), FACTS, ERRORS) for name, scans in (("same", every), ("flat", flat))
    ]
    document = validate(every, candidates, tmp_path, SMALL)
    assert_identical(document["packs"][0])
    assert document["packs"][1]["image_rmse"] > 1


def test_a_map_under_another_name_is_another_skin(character, tmp_path):
    numbers = np.random.default_rng(1).random((64, 64, 1), np.float32)
    settings = one_look(Thresholds(), max_spp=4)
    documents = []
    for name in ("roughness", "cavity"):
        scans = with_maps(character, **{name: numbers})
        earlier = tmp_path / "roughness" if documents else None
        candidate = Candidate("one", staged_original(scans), FACTS, ERRORS)
        documents.append(validate(scans, [candidate], tmp_path / name, settings, earlier))
    assert [document["rendered"] for document in documents] == [3, 3]


@pytest.mark.parametrize("change", [{"seed": 1}, {"material": "diffuse"}, {"resolution": 40}, {"max_spp": 4}])
def test_changed_settings_reuse_nothing(character, finished, tmp_path, change):
    _, folder, settings = finished
    changed = replace(settings, lights=("studio",), **change)
    assert validate(character, [brighter(character, 0.02)], tmp_path, changed, folder)["rendered"] == 3


def test_more_lights_keep_the_renders_of_the_others_and_fewer_leave_nothing_behind(character, finished, tmp_path):
    _, folder, settings = finished
    candidates = [brighter(character, 0.02)]
    fewer = validate(character, candidates, tmp_path, replace(settings, lights=("side",)), folder)
    assert fewer["rendered"] == 0
    names = {"neutral.front.side", "smile.front.side", "frown.front.side"}
    expected = {f"{name}{suffix}" for name in names for suffix in (".exr", ".json")} | {"front.side.floor.json"}
    assert {*files_of(tmp_path)} == expected


def test_a_worker_s_threads_end_with_it(character, tmp_path):
    before = {*threading.enumerate()}
    with Filler(character, [same(character)], tmp_path, SMALL) as filler:
        assert filler.fill(character.expressions[0]).rendered
        ours = {thread for thread in {*threading.enumerate()} - before if thread.name.startswith("ThreadPool")}
    assert ours
    assert not any(thread.is_alive() for thread in ours)
