"""The command that tries the plugin on a foreign project; it takes a minute of runs of pytest, so few of them here."""

from tests.suite.__main__ import DEFECTS, FILES, PROJECT, measure


def test_equal_images_pass_and_a_defect_is_found():
    defect = "one pixel to the right"
    document = measure(2, 1, {defect: DEFECTS[defect]})
    assert document["all"]["failed"] == 0
    assert {name: row["trials"] for name, row in document["equal"].items()} == dict.fromkeys(FILES, 2)
    assert document["defects"][defect]["failed"] == document["defects"][defect]["trials"] == 1


def test_every_defect_is_one_that_its_file_knows():
    for defect, of in DEFECTS.items():
        assert f'DEFECT == "{defect}"' in (PROJECT / f"{of}.py").read_text()
