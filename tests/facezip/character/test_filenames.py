"""Names of files: one character, however systems and programs spell its names."""

import unicodedata
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from facezip.character.filenames import (
    at_rest,
    first_tile,
    is_at_rest,
    is_like_a_mask,
    is_litter,
    readings,
    tile_number,
)
from facezip.character.maps import KNOWN
from facezip.names import folded, is_safe_name, one_form, printable

NAMES = st.text(st.characters(categories=("L", "Nd"), include_characters="_-. "), min_size=1, max_size=20).filter(
    is_safe_name
)
TILES = st.tuples(st.integers(0, 9), st.integers(0, 20))
SPELLINGS = {
    "udim": lambda column, row: str(1001 + column + 10 * row),
    "from one": lambda column, row: f"u{column + 1}_v{row + 1}",
    "capitals": lambda column, row: f"U{column + 1}_V{row + 1}",
    "joined": lambda column, row: f"u{column + 1}v{row + 1}",
}


@given(NAMES, st.sampled_from(["", *KNOWN]), TILES, st.sampled_from([*SPELLINGS]), st.sampled_from("._- "))
def test_a_name_is_put_together_and_taken_apart_again(name, map, tile, spelling, between):
    written = SPELLINGS[spelling](*tile)
    stem = f"{name}{'.' + map if map else ''}{between}{written}"
    found = next(parts for parts in readings(stem) if folded(parts.name) == folded(name))
    assert (found.map, found.tile) == (map, written)
    assert tile_number(found.tile, first_tile([found.tile])) == 1001 + tile[0] + 10 * tile[1]


@given(NAMES, st.sampled_from(["", *KNOWN]), st.sampled_from(["NFC", "NFD"]), st.sampled_from([str.upper, str.lower]))
def test_case_and_unicode_form_do_not_count(name, map, form, case):
    assume(folded(case(name)) == folded(name))
    stem = unicodedata.normalize(form, case(f"{name}.{map}" if map else name))
    assert any((folded(parts.name), parts.map) == (folded(name), map) for parts in readings(stem))


@given(st.text())
def test_names_are_compared_in_one_form(text):
    forms = [unicodedata.normalize(form, text) for form in ("NFC", "NFD")]
    assert len({*map(folded, forms)}) == len({*map(one_form, forms)}) == 1
    assert folded(folded(text)) == folded(text)


@given(TILES, st.lists(TILES, max_size=5))
def test_columns_and_rows_count_from_zero_where_one_is_called_so(tile, others):
    written = ["u0_v0", *(f"u{column}_v{row}" for column, row in [tile, *others])]
    first = first_tile(written)
    assert first == 0
    assert tile_number(written[1], first) == 1001 + tile[0] + 10 * tile[1]


@pytest.mark.parametrize("written", ["u11_v1", "u0_v0", "u99_v99"])
def test_a_tile_without_a_number_is_none(written):
    with pytest.raises(ValueError, match="no tile"):
        tile_number(written, 1)


@given(
    st.sampled_from(
        ["neutral", "Neutral", "NEUTRAL_FACE", "base", "Basis", "rest", "rest_pose", "default", "BaseMesh"]
    ),
    st.sampled_from(["", "000_", "01 ", "ada_", "Ada-head_"]),
    st.sampled_from(["", "_01", ".000", "_v2_final"]),
    st.lists(st.sampled_from(["smile", "nod", "brow_up", "blink"]), min_size=2, max_size=4, unique=True),
)
def test_the_one_mesh_that_is_called_as_a_face_at_rest_is_found(rest, before, behind, others):
    names = [f"{before}{name}{behind}" for name in (rest, *others)]
    assert at_rest(names) == [names[0]]
    assert is_at_rest(rest)


@given(st.lists(st.sampled_from(["smile", "nod", "mouth_open", "neutralise", "baseball"]), min_size=2, unique=True))
def test_no_other_mesh_is_taken_for_it(names):
    assert at_rest(names) == []
    assert not any(map(is_at_rest, names))


@given(NAMES.filter(lambda name: not name.startswith("~$")))
def test_what_is_hidden_is_litter_wherever_it_lies(name):
    assert is_litter(Path(f"._{name}.png"))
    assert is_litter(Path(f".cache/{name}.png"))
    assert is_litter(Path(f"__MACOSX/{name}.png"))
    assert not is_litter(Path(f"scans/{name}.png"))


@pytest.mark.parametrize("stem", ["masks", "Mask_face", "face_mask", "MASK2", "head-mask.1001", "mask (1)"])
def test_what_people_would_call_a_mask_is_like_one(stem):
    assert is_like_a_mask(stem)


@given(st.sampled_from(["4.2\u00a0%", "3\u202f000", "1\u2009mm"]), st.text())
def test_our_own_spaces_reach_the_terminal_and_nothing_that_it_would_obey_does(ours, text):
    shown = printable(f"{ours}{text}")
    assert shown.startswith(ours)
    assert all(c.isprintable() or unicodedata.category(c) == "Zs" for c in shown)
