"""What is beside the head: sliders by name, search, keys, poses; and names that try to be more than names."""

from dataclasses import replace

import pytest

from facezip.export.web import export_web
from facezip.pack.write import write_pack
from tests.browser.conftest import Viewer, served, viewing
from tests.facezip.conftest import random_model
from tests.facezip.viewer.models import random_maps, random_scans

SHAPES = (
    "browInnerUp", "browDownLeft", "browDownRight", "eyeBlinkLeft", "eyeBlinkRight", "cheekPuff", "jawOpen", "jawLeft",
    "mouthPucker", "mouthSmileLeft", "mouthSmileRight", "noseSneerLeft", "noseSneerRight", "tongueOut",
)  # fmt: skip
HOSTILE = ("<img src=x onerror=document.body.dataset.owned=1>", "\"'><script>alert(1)<", "$(touch owned) && `id`")
PLACES = """scrollTo(0, 0), JSON.stringify(
  [...document.querySelectorAll("#stage, #transport, #view, #expressions")].map((part) => part.getBoundingClientRect())
)"""
WEIGHTS = "Array.from(facezip.state.weights)"


def written(folder, names, title="random"):
    model = random_model(expressions=len(names), meshes=True)
    write_pack(replace(model, expressions=names), folder / "a.facezip", name=title)
    return folder / "a.facezip"


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    return written(tmp_path_factory.mktemp("many"), SHAPES)


def test_many_names_come_in_groups_and_can_be_searched(context, many):
    with viewing(context, many) as viewer:
        groups = viewer.page.locator("#sliders h3").all_inner_texts()
        assert groups == ["Brows", "Eyes", "Nose", "Cheeks", "Jaw", "Mouth", "Tongue"]
        viewer.page.get_by_placeholder("Search").fill("smile left")
        assert viewer.page.locator(".slider:visible label").all_inner_texts() == ["mouthSmileLeft"]
        viewer.page.get_by_placeholder("Search").fill("nobody")
        assert viewer.page.get_by_text("No such name.").is_visible()


def test_everything_works_from_the_keyboard(context, many):
    with viewing(context, many) as viewer:
        page = viewer.page
        page.get_by_label("jawOpen", exact=True).press("ArrowRight")
        assert page.evaluate(WEIGHTS)[SHAPES.index("jawOpen")] == pytest.approx(0.01)
        page.keyboard.press("n")
        assert page.evaluate(WEIGHTS) == [0] * len(SHAPES)
        page.keyboard.press("r")
        assert sum(weight > 0 for weight in page.evaluate(WEIGHTS)) in (2, 3)
        page.keyboard.press("u")
        assert page.get_by_label("Layout", exact=True).is_checked()
        page.keyboard.press("u")
        before = page.evaluate("facezip.stage.orbit.camera.position.toArray()")
        page.locator("#canvas").press("ArrowLeft")
        assert page.evaluate("facezip.stage.orbit.camera.position.toArray()") != before


def test_poses_and_the_animation_move_the_sliders(context, many):
    with viewing(context, many) as viewer:
        page = viewer.page
        page.get_by_label("Pose").select_option("cheekPuff")
        assert page.locator("#weight-5").input_value() == "1"
        page.locator("#play").click()
        page.locator("#time[aria-valuetext]").wait_for()
        page.locator("#play").click()
        moved = float(page.locator("#time").input_value())
        page.wait_for_timeout(200)
        assert float(page.locator("#time").input_value()) == moved


def test_a_menu_shows_each_map(context, tmp_path):
    write_pack(random_maps(tiles=(1001, 1002)), tmp_path / "a.facezip")
    with viewing(context, tmp_path / "a.facezip") as viewer:
        page = viewer.page
        assert "albedo, normal, roughness, 2 tiles" in page.locator("#facts").inner_text()
        pictures = {"skin": viewer.pixels().tobytes()}
        for name in ("albedo", "normal", "roughness"):
            viewer.choose("Map", name)
            assert page.get_by_label("Flat", exact=True).is_checked()
            pictures[name] = viewer.pixels().tobytes()
        assert len({*pictures.values()}) == 4
        viewer.choose("Show", "Skin")
        page.keyboard.press("m")
        assert page.get_by_label("albedo", exact=True).is_checked()


def test_one_map_needs_no_menu(context, many):
    with viewing(context, many) as viewer:
        assert viewer.page.get_by_text("Map", exact=True).count() == 0
        assert viewer.page.get_by_text("Clay", exact=True).count() == 0


def test_an_original_that_does_not_arrive_is_said(context, tmp_path):
    model = random_maps()
    write_pack(model, tmp_path / "a.facezip")
    with served(tmp_path / "a.facezip", random_scans(model)) as address, context.new_page() as page:
        page.route("**/tile_0.map_1.original_2.png", lambda route: route.fulfill(status=503))
        page.goto(address)
        viewer = Viewer(page)
        viewer.slide({"expr_2": 1.0})
        viewer.choose("Side", "Original")
        words = "Not everything is shown: tile_0.map_1.original_2.png: the server answers 503."
        page.get_by_text(words, exact=True).wait_for()


@pytest.mark.parametrize("size", [(360, 700), (1280, 720)])
def test_nothing_overflows_and_nothing_moves(context, many, size):
    with viewing(context, many) as viewer:
        page = viewer.page
        page.set_viewport_size({"width": size[0], "height": size[1]})
        before = page.evaluate(PLACES)
        for view in ("Flat", "Weights", "Differences", "Change", "UV", "Skin"):
            viewer.choose("Show", view)
            viewer.slide({"jawOpen": 0.5})
            assert page.evaluate(PLACES) == before
        assert not page.evaluate("document.documentElement.scrollWidth > innerWidth")


@pytest.mark.parametrize("single", [False, True])
def test_hostile_names_do_nothing_but_be_shown(context, tmp_path, single):
    pack = written(tmp_path, HOSTILE, title=HOSTILE[0])

    def look(viewer):
        page = viewer.page
        assert page.locator(".slider label").all_text_contents() == list(HOSTILE)
        assert {*HOSTILE} < {*page.locator("#pose option").all_text_contents()}
        assert page.locator("h1").text_content() == HOSTILE[0]
        assert page.title().startswith(HOSTILE[0])
        assert page.locator("img").count() == 0
        assert page.evaluate("document.body.dataset.owned") is None

    if single:
        export_web(pack, tmp_path / "page.html")
        with context.new_page() as page:
            page.goto((tmp_path / "page.html").as_uri())
            look(Viewer(page))
    else:
        with viewing(context, pack) as viewer:
            look(viewer)
