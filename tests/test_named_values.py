"""Options that take values by name: none is dropped, and every name of an expression can be said."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.commands.decompress import parse_blend
from facezip.commands.fit_options import DEFAULTS, request_of
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.animation import read_animation
from facezip.names import is_safe_name

# Of the letters that part one name from the next, too.
NAMES = st.text("ab=, é", min_size=1, max_size=6).filter(is_safe_name)
BLENDS = st.dictionaries(NAMES, st.floats(-9, 9), min_size=1, max_size=4)


def written(weights):
    return ",".join(f"{name}={weight}" for name, weight in weights.items())


def refusal(call, *arguments):
    with pytest.raises(FaceZipError) as refused:
        call(*arguments)
    assert refused.value.code is ErrorCode.BAD_VALUE
    return str(refused.value)


@given(weights=BLENDS, others=st.sets(NAMES))
def test_a_blend_is_read_as_it_was_written_whatever_its_names_hold(weights, others):
    names = {*weights, *others}
    assert parse_blend(written(weights), names) == weights
    assert parse_blend(unicodedata.normalize("NFD", written(weights)), names) == weights


@given(weights=BLENDS, others=st.sets(NAMES))
def test_a_name_twice_in_a_blend_is_refused(weights, others):
    again = f"{written(weights)},{written({min(weights): 0.25})}"
    assert "each name once" in refusal(parse_blend, again, {*weights, *others})


@pytest.mark.parametrize("text", ["", ",", "a", "a=", "a=1,", ",a=1", "a=1,,b=1", "a=much"])
def test_what_is_no_blend_is_refused(text):
    assert "--blend" in refusal(parse_blend, text, ("a", "b"))


def test_names_that_are_unknown_are_left_for_the_pack_to_refuse():
    assert parse_blend("a=1, c = 2, a=1=3", ("a",)) == {"a": 1, "c": 2, "a=1": 3}


def test_a_map_twice_is_refused():
    pairs = ("normal=0.5", " normal=2")
    assert "each map once" in refusal(request_of, {**DEFAULTS, "map_weights": pairs})
    assert request_of({**DEFAULTS, "map_weights": ("normal=0.5", "roughness=2")}).map_weights == {
        "normal": 0.5,
        "roughness": 2,
    }


def test_an_expression_twice_in_an_animation_is_refused_in_whichever_form_of_unicode(tmp_path):
    frames = tmp_path / "frames.csv"
    frames.write_text("é,e\N{COMBINING ACUTE ACCENT}\n0,1\n", encoding="utf-8")
    assert "a name twice" in refusal(read_animation, frames)
    frames.write_text("e\N{COMBINING ACUTE ACCENT}\n1\n", encoding="utf-8")
    assert read_animation(frames) == [{"é": 1}]


@pytest.mark.parametrize(("largest", "warned"), [("10", False), ("-11", True), ("100", True)])
def test_weights_in_percents_are_asked_about_and_gains_are_not(tmp_path, caplog, largest, warned):
    frames = tmp_path / "frames.csv"
    frames.write_text(f"smile,gains.expressions.smile\n0.5,50\n{largest},1\n")
    assert read_animation(frames)[1]["smile"] == float(largest)
    assert any("divide percents by 100" in message for message in caplog.messages) == warned
