"""File names: readable where they can be, safe always, never shared by two tests."""

import re

from hypothesis import given
from hypothesis import strategies as st

from render.plugin.names import file_stem


def test_an_ordinary_test_is_named_as_it_is():
    assert (
        file_stem("tests/test_skin.py::test_rig::test_a[studio-1]", "left")
        == "tests.test_skin.test_rig.test_a.studio-1.left"
    )


@given(st.text(max_size=300), st.text(max_size=20))
def test_every_name_is_one_safe_file(parameter, name):
    stem = file_stem(f"test_a.py::test[{parameter}]", name)
    assert re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,130}", stem)
    assert ".." not in stem


@given(st.lists(st.text(max_size=200), min_size=2, max_size=2, unique=True))
def test_different_parameters_have_different_files(parameters):
    first, second = (file_stem(f"test_a.py::test[{parameter}]") for parameter in parameters)
    assert first.lower() != second.lower()


@given(st.text(min_size=1, max_size=30).filter(lambda text: text.upper() != text.lower()))
def test_parameters_that_differ_in_case_alone_share_no_file(parameter):
    first, second = (file_stem(f"test_a.py::test[{each}]") for each in (parameter.upper(), parameter.lower()))
    assert first.lower() != second.lower()
