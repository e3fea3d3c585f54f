"""Conditions: everything that a document states is said."""

from reports.conditions import condition_rows, glossary, words
from reports.metrics import FLOOR


def test_every_condition_is_a_row_known_or_not(document):
    document["conditions"]["lens_cap"] = "off"
    rows = dict(condition_rows(document))
    assert rows["Samples per pixel"] == "16"
    assert rows["Lens cap"] == "off"
    assert len(rows) == len(document["conditions"]) - len(["units"]) + len(["Character", "Time", "Speed"])


def test_plain_data_reads_as_words():
    assert words([{"name": "front", "azimuth": 38.0}, {"name": "side"}]) == "front (azimuth 38); side"
    assert words(["a", 2, None]) == "a, 2, none"


def test_the_glossary_explains_what_was_measured_with_its_unit(document):
    rows = {label: unit for label, _, unit in glossary(document)}
    assert rows["Image RMSE"] == "0..255 over head pixels"
    assert FLOOR[0] in rows
    del document["packs"][0]["flip"]
    assert "FLIP" not in {label for label, _, _ in glossary(document)}
