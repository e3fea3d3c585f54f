"""Where on the face: places and regions in the report."""

import pytest

from reports.images import ColourScale
from reports.places import limits_of, region_table, tally, worst_places
from tests.reports.conftest import make_document
from tests.reports.test_validation import HOSTILE, page_of

LIMITS = {
    "indistinguishable": {"delta_e": 1.0, "flip": 0.05, "local": 2.0},
    "visible": {"delta_e": 3.0, "flip": 0.1, "local": 6.0},
}


@pytest.fixture
def placed(tmp_path):
    document = make_document(tmp_path, packs=("a", "b"))
    document["conditions"] |= {"thresholds": LIMITS, "max_spp": 64}
    render = document["renders"][3]
    where = {key: render[key] for key in ("expression", "view", "light", "exr")}
    for value, pack in enumerate(document["packs"], 1):
        place = {"region": "left cheek", "delta_e_p95": 1.25 * value, "box": [4, 6, 10, 10]}
        pack |= {"worst_place": where | place, "levels": {"indistinguishable": 3, "visible": 1}, "decided": True}
        pack["regions"] = {"left cheek": {"value": 1.25 * value, **where}, "chin": {"value": 0.5, **where}}
    del document["packs"][1]["regions"]["chin"]
    return document


def test_a_place_is_cut_from_its_render(placed, tmp_path):
    first, second = worst_places(placed["packs"], tmp_path, ColourScale(16))
    assert (first.pack, first.region, first.error, second.error) == ("a", "left cheek", "1.25", "2.50")
    assert first.original == second.original != first.compressed != second.compressed


def test_the_page_shows_places_regions_limits_and_tallies(placed, tmp_path):
    page = page_of(placed, tmp_path)
    assert page.count("figure", "crop") == 6
    assert page.count("table", "regions") == 1
    text = " ".join(page.words)
    assert "left cheek" in text
    assert "Renders: 3 indistinguishable, 1 visible" in text
    assert "ΔE2000 p95 ≤ 1, in the worst place ≤ 2, FLIP ≤ 0.05" in text


def test_a_region_that_a_pack_was_not_measured_in_says_so(placed):
    table = region_table(placed["packs"])
    assert [row.name for row in table.rows] == ["left cheek", "chin"]
    assert table.rows[1].cells[1].note == "not seen"


def test_identical_packs_and_older_documents_have_no_places(document, tmp_path):
    document["packs"][0]["worst_place"] = None
    page = page_of(document, tmp_path)
    assert page.count("figure", "crop") == 0
    assert region_table(document["packs"]) is None
    assert limits_of(document["conditions"]) == []
    assert tally(document["packs"][0]) == ""


def test_doubt_is_shown():
    assert "too close" in tally({"levels": {"visible": 2}, "decided": False})


def test_hostile_regions_are_text(placed, tmp_path):
    placed["packs"][0]["worst_place"]["region"] = HOSTILE
    placed["packs"][0]["regions"] = {HOSTILE: {"value": 1.0, "expression": HOSTILE, "view": HOSTILE, "light": HOSTILE}}
    page = page_of(placed, tmp_path)
    assert page.handlers == []
    assert page.count("figure", "crop") == 6
