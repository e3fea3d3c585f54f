"""Charts: geometry that is true to its numbers."""

import itertools

import pytest

from reports.figures import Series, lying_bars, nice_ticks, upright_bars

GROUPS = ("smile", "frown", "sneer")
SERIES = (
    Series("ours", {"smile": 1.0, "frown": 2.0, "sneer": 0.0}, "1.00", "pack-0"),
    Series("theirs", {"smile": 4.0, "sneer": 3.0}, "3.50", "rival-0"),
)


@pytest.mark.parametrize("largest", [1e-4, 0.3, 1.0, 2.67, 9.99, 10.0, 4321.0])
def test_ticks_are_even_start_at_zero_and_reach_the_largest_value(largest):
    ticks = nice_ticks(largest)
    steps = [b - a for a, b in itertools.pairwise(ticks)]
    assert ticks[0] == 0
    assert largest <= ticks[-1] * (1 + 1e-9) <= 2 * largest
    assert max(steps) == pytest.approx(min(steps))
    assert 3 <= len(ticks) <= 7


def test_ticks_of_nothing_are_still_an_axis():
    assert nice_ticks(0.0) == [0.0, 1.0]


@pytest.mark.parametrize(("draw", "side"), [(upright_bars, "height"), (lying_bars, "width")])
def test_lengths_are_proportional_to_values(draw, side):
    lengths = [getattr(bar, side) for bar in draw(GROUPS, SERIES).bars]
    unit = lengths[0]
    assert lengths == pytest.approx([unit, 4 * unit, 2 * unit, 0, 0, 3 * unit], abs=0.02)


@pytest.mark.parametrize("draw", [upright_bars, lying_bars])
def test_bars_stay_inside_and_apart(draw):
    chart = draw(GROUPS, SERIES)
    for bar in chart.bars:
        assert chart.left <= bar.x
        assert bar.x + bar.width <= chart.right + 0.01
        assert chart.top <= bar.y
        assert bar.y + bar.height <= chart.bottom + 0.01
    starts = [bar.x if chart.upright else bar.y for bar in chart.bars]
    thickness = chart.bars[0].width if chart.upright else chart.bars[0].height
    assert all(b - a >= thickness - 0.02 for a, b in itertools.pairwise(starts))


def test_a_value_that_was_not_measured_says_so():
    titles = [bar.title for bar in upright_bars(GROUPS, SERIES).bars]
    assert "frown · theirs: not measured" in titles
    assert "sneer · ours: 0.00" in titles
