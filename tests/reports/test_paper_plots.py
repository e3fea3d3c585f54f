"""Plots are true to their numbers."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest

from facezip.documents.document import from_plain
from reports.paper import figure_6, figure_7_left, figure_7_right, figure_8
from reports.paper.documents.figures import ConvergenceFigure, ErrorFigure, MasksFigure, ShapesFigure
from reports.plots import Axis, dot, round_ticks

SIZE = (8, 8)
FIGURE_6 = ErrorFigure(
    resolution=SIZE,
    rmse={"refined": 1.0, "paper": 3.0},
    rmse_per_expression={"refined": {"a": 0.5, "b": 1.5}, "paper": {"a": 2.0, "b": 4.0}},
)
HISTORY = ConvergenceFigure(
    resolution=SIZE,
    masks=5,
    history=[[9.0, 5.0, 4.0], [8.0, 6.0, 5.0], [7.0, 5.0, 5.0]],
    cost={"paper": 4.0},
    seconds={"paper": 2.0, "lower_bound": 1.5},
    lower_bound=None,
    gap={"paper": None},
)
CHOSEN = {"paper": {"cost": 1.0, "rmse": 2.1}}
COUNTS = [{"masks": k, "costs": [1.0] * 5, "rmse": [2.0, 2.25, 2.5, 3.0, 4.0], "chosen": CHOSEN} for k in (5, 13, 53)]
MASKS = from_plain(
    {"resolution": SIZE, "starts": 5, "without_masks": {"refined": 1.0, "pca_4": 3.0}, "counts": COUNTS}, MasksFigure
)


def points(path):
    return [tuple(map(float, pair)) for pair in re.findall(r"([-\d.]+) ([-\d.]+)", path)]


@pytest.mark.parametrize(("low", "high"), [(0, 1), (21.8, 29.1), (3.42, 4.05), (-2, 5), (1e-6, 3e-6), (7, 7), (0, 0)])
def test_ticks_are_even_and_hold_the_values(low, high):
    ticks = round_ticks(low, high)
    steps = [b - a for a, b in itertools.pairwise(ticks)]
    assert ticks[0] <= low
    assert ticks[-1] >= high
    assert max(steps) == pytest.approx(min(steps))
    assert 2 <= len(ticks) <= 9


def test_an_axis_is_linear_and_its_ticks_have_the_same_decimals():
    axis = Axis.around([1.1, 2.4], 300, 20, 5)
    assert axis.at(axis.low) == 300
    assert axis.at(axis.high) == 20
    assert axis.at((axis.low + axis.high) / 2) == pytest.approx(160)
    assert len({len(text.partition(".")[2]) for _, text in axis.marks()}) == 1


@pytest.mark.parametrize("shape", ["disc", "square", "open-diamond", "triangle"])
def test_a_mark_lies_about_its_point(shape):
    mark = dot((50, 80), shape, "pack-0")
    assert (mark.kind == "hollow") == shape.startswith("open-")
    if shape != "disc":
        np.testing.assert_allclose(np.mean(points(mark.path), axis=0), (50, 80), atol=0.1)


@pytest.mark.parametrize(("draw", "axis"), [(figure_6.upright, 1), (figure_6.lying, 0)])
def test_every_error_is_a_mark_at_its_place(draw, axis):
    plot = draw(FIGURE_6)
    ticks = {float(text): position for position, text in (plot.x_ticks or plot.y_ticks)}
    unit = (ticks[4.0] - ticks[0.0]) / 4
    marks = [mark for mark in plot.marks if mark.title]
    assert len(marks) == 4
    assert [label.text for label in plot.labels] == ["b", "a"]
    for mark in marks:
        value = float(mark.title.rpartition(" ")[2])
        if "Paper" in mark.title:
            assert np.mean(points(mark.path), axis=0)[axis] == pytest.approx(ticks[0.0] + value * unit, abs=0.1)


def test_a_swarm_keeps_heights_and_its_dots_apart():
    heights = sorted(np.random.default_rng(0).normal(200, 20, 100))
    placed = figure_7_left._swarm(heights, 300)
    assert [y for _, y in placed] == heights
    for (ax, ay), (bx, by) in itertools.combinations(placed, 2):
        assert abs(ax - bx) >= figure_7_left.GAP - 1e-6 or abs(ay - by) >= figure_7_left.GAP


def test_labels_are_moved_apart_and_never_up():
    places = [10.0, 11.0, 50.0]
    moved = figure_7_left._apart(places, 17)
    assert moved == [10.0, 27.0, 50.0]


def test_convergence_has_a_line_a_start_and_the_best_once_more():
    plot = figure_7_left.convergence(HISTORY, 560)
    assert len(plot.marks) == 4
    assert plot.marks[3].path == plot.marks[0].path
    bounded = replace(HISTORY, cost={"paper": 4.0, "paper_optimised": 3.5}, lower_bound=3.0)
    assert [mark.kind for mark in figure_7_left.convergence(bounded, 560).marks[4:]] == ["line", "dashed"]
    assert [label.text for label in figure_7_left.ends(bounded, 560).labels] == [
        "best of 3 4.00", "our search 3.50", "lower bound 3.00",
    ]  # fmt: skip


def test_the_table_of_searches_has_every_cost_its_gap_and_its_seconds():
    figure = replace(
        HISTORY, cost={"paper": 4.0, "paper_optimised": 3.75}, gap={"paper": 0.25, "paper_optimised": 0.2},
        seconds={"paper": 2.0, "paper_optimised": 0.05, "lower_bound": 1.5}, lower_bound=3.0,
    )  # fmt: skip
    rows = figure_7_left.table(figure).rows
    assert [row.note for row in rows[:2]] == ["beam search", "best of 3 starts"]
    assert [[cell.text for cell in row.cells] for row in rows] == [
        ["3.75", "20.0", "0.050"], ["4.00", "25.0", "2.000"], ["3.00", "–", "1.500"],
    ]  # fmt: skip


def test_a_bound_that_nobody_knows_is_a_dash():
    assert [cell.text for row in figure_7_left.table(HISTORY).rows for cell in row.cells] == [
        "4.00", "–", "2.000", "–", "–", "1.500",
    ]  # fmt: skip


@pytest.mark.parametrize("width", [380, 560])
def test_boxes_stand_apart_inside_the_frame(width):
    for draw in (figure_7_right.whole, figure_7_right.magnified):
        plot = draw(MASKS, width)
        boxes = [mark for mark in plot.marks if mark.kind == "hollow"]
        edges = [points(box.path.replace("H", "L0 ").replace("V", "L0 "))[0][0] for box in boxes]
        assert len(boxes) == 3
        assert edges == sorted(edges)
        for mark in plot.marks:
            for x, y in points(mark.path) if mark.kind == "line" else []:
                assert plot.left - 1 <= x <= plot.right + 1
                assert plot.top - 1 <= y <= plot.bottom + 1


@pytest.mark.parametrize(
    ("condition", "words"), [(2.5, "cond(B) = 2.5"), (np.inf, "B has no inverse"), (None, "B has no inverse")]
)
def test_weights_without_an_inverse_are_said(condition, words):
    figure = ShapesFigure(
        resolution=SIZE,
        condition=condition,
        damping=0.1,
        unseen=[],
        columns=["naive", "paper"],
        pictures={"a": "data:"},
    )
    assert words in figure_8._intro(figure)
    assert figure_8.errors_of(figure) is None
