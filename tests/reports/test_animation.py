"""The contact sheet of an animation: frames in their order, none twice, the worst among them."""

from hypothesis import given
from hypothesis import strategies as st

from reports.animation import COLUMNS, _chosen


@given(st.integers(1, 200), st.data())
def test_a_contact_sheet_shows_as_many_frames_as_fit_and_the_worst(count, data):
    worst = data.draw(st.integers(0, count - 1))
    chosen = _chosen(count, worst)
    assert chosen == sorted({*chosen})
    assert len(chosen) == min(COLUMNS, count)
    assert worst in chosen
    assert {*chosen} <= {*range(count)}
