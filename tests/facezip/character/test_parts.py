"""Which names say that something is no face: whole words of them, however these are run together."""

import pytest

from facezip.character.parts import is_called, listed, without_inner

INNER = ["teeth", "EyeLeft", "eye_L", "Wolf3D_Teeth", "leftEye", "m.eyelashes.001", "EYES", "head/tongue", "CornealEye"]
OUTER = [
    "head",
    "skin",
    "student",
    "solid",
    "Charlotte",
    "legacy",
    "capture_a",
    "thumbnail",
    "M_1",
    "Armature",
    "",
    "面",
]


@pytest.mark.parametrize("name", INNER)
def test_parts_in_and_on_the_face_are_known_by_their_words(name):
    assert without_inner([("head",), ("mesh", name)]) == [0]


@pytest.mark.parametrize("name", OUTER)
def test_letters_within_a_word_say_nothing(name):
    assert without_inner([(name,), ("teeth",)]) == [0]


def test_names_compare_in_one_form_whatever_their_case():
    assert is_called("\u00c9lan", ["x", "e\u0301LAN"])
    assert not is_called("Elan", ["\u00c9lan"])


def test_many_names_are_counted():
    assert listed("ab") == "'a', 'b'"
    assert listed(map(str, range(11))) == "'0', '1', '2', '3', '4', '5', '6', '7' and 3 more"
