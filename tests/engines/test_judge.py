"""The second judge sees nothing where there is nothing, what there is, and from where the first one looks."""

import pytest

from facezip.character.loading import load_character, save_character
from facezip.documents.document import to_json
from facezip.fit.methods import compress
from facezip.pack.write import write_pack
from render.candidates import candidate
from render.settings import Settings
from render.validation import validate
from scenes.cameras import VIEWS
from scenes.character import make_character
from scenes.face.capture import MAPS
from tests.engines import cycles
from tests.engines.judge import judged

# Of Cycles, where its noise is to be the size of Mitsuba's, and where the glint of an eye must not decide.
FEW, MANY = 16, 256


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """A small demo with Mitsuba's verdict."""
    cycles.needed()
    demo = tmp_path_factory.mktemp("demo")
    save_character(make_character(128, 2, maps=MAPS[:2]), demo / "character")
    scans = load_character(demo / "character")
    write_pack(compress(scans, "pca", differences=1), demo / "character.facezip")
    (demo / "report").mkdir()
    settings = Settings(views=VIEWS[1:2], lights=("side",), resolution=96, spp=FEW, max_spp=FEW)
    document = validate(scans, [candidate(scans, demo / "character.facezip")], demo / "report", settings)
    (demo / "report" / "report.json").write_text(to_json(document), encoding="utf-8")
    return demo


def test_both_judges_see_the_same_scene(demo):
    _, floor, agreement, _ = judged(demo, "three_quarter_left", "side", FEW)
    assert agreement < 2 * floor.image_rmse


def test_the_judges_agree(demo):
    rows = judged(demo, "three_quarter_left", "side", MANY)[0]
    neutral = next(theirs for name, _, theirs in rows if name == "neutral")
    assert neutral["image_rmse"] < 0.1
    for name, mitsuba, theirs in rows:
        if name != "neutral":
            assert theirs["flip"] == pytest.approx(mitsuba["flip"], rel=0.1)
            assert theirs["image_rmse"] == pytest.approx(mitsuba["image_rmse"], rel=0.25)
