"""Numbers as text: never a small value as none, never a missing one as zero."""

import pytest

from reports.metrics import BY_KEY, METRICS, MISSING, floor_text, measured, number


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(0, 2, "0"), (0.0, 4, "0"), (1.0, 4, "1"), (0.99999, 4, "1.0000"), (0.004, 2, "<0.01"), (0.0051, 2, "0.01"),
     (-0.004, 2, ">-0.01"), (12.345, 1, "12.3")],
)  # fmt: skip
def test_exact_values_are_bare_and_small_ones_are_not_hidden(value, digits, text):
    assert number(value, digits) == text


def test_only_psnr_is_infinite_without_a_value():
    assert {metric.key for metric in METRICS if metric.text(None) == "∞"} == {"psnr"}
    assert BY_KEY["ssim"].of({}) == MISSING


def test_a_pack_states_its_floors_beside_that_of_the_image_rmse_and_a_render_all_in_one():
    assert floor_text(BY_KEY["flip"], {"noise_floor": 0.7, "noise_floor_per_metric": {"flip": 0.1}}) == "0.1000"
    assert floor_text(BY_KEY["flip"], {"noise_floor": {"flip": 0.2}}) == "0.2000"
    assert floor_text(BY_KEY["flip"], {"noise_floor": {"image_rmse": 0.7}}) == ""


def test_measured_keeps_the_order_of_reports():
    keys = [metric.key for metric in measured(METRICS, [{"ssim": 1}, {"flip": 0, "image_rmse": 2}])]
    assert keys == ["image_rmse", "flip", "ssim"]
