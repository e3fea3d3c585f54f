import numpy as np
import pytest

from render.documents.images import ImageMetrics
from render.metrics import Picture, compare, display, head_crop

RNG = np.random.default_rng(0)
A = RNG.random((48, 40, 3)).astype(np.float32)
B = np.clip(A + RNG.normal(0, 0.05, A.shape), 0, 1).astype(np.float32)
HEAD = np.ones(A.shape[:2], bool)


def test_equal_pictures_have_no_error_in_any_metric():
    metrics = compare(Picture(A, HEAD), Picture(A.copy(), HEAD))
    assert metrics == ImageMetrics(
        image_rmse=0, psnr=None, flip=0, delta_e_mean=0, delta_e_p95=0, delta_e_local=0, ssim=1
    )


def test_metrics_are_symmetric():
    one, other = Picture(A, HEAD), Picture(B, HEAD)
    assert vars(compare(one, other)) == pytest.approx(vars(compare(other, one)), abs=1e-5)


def test_a_larger_error_counts_for_more():
    small, large = (compare(Picture(A, HEAD), Picture(A + t * (B - A), HEAD)) for t in (np.float32(0.5), np.float32(1)))
    for metric in ("image_rmse", "flip", "delta_e_mean", "delta_e_p95", "delta_e_local"):
        assert 0 < getattr(small, metric) < getattr(large, metric)
    assert 1 > small.ssim > large.ssim


def test_pixels_beside_the_head_do_not_count():
    head = HEAD.copy()
    head[:, 20:] = False
    spoilt = A.copy()
    spoilt[:, 39] = 0
    found = compare(Picture(A, head), Picture(spoilt, head))
    assert found.delta_e_p95 == found.delta_e_local == 0


def test_a_spoilt_place_counts_however_large_the_head():
    """A percentile of the whole does not see what covers less than a twentieth of it."""
    skin, head = np.full((200, 200, 3), 0.6, np.float32), np.ones((200, 200), bool)
    spoilt = skin.copy()
    spoilt[90:110, 90:110] = [0.2, 0.9, 0.2]
    found = compare(Picture(skin, head), Picture(spoilt, head))
    whole = compare(Picture(skin, head), Picture(np.broadcast_to(spoilt[100, 100], skin.shape), head))
    assert found.delta_e_p95 == 0
    assert found.delta_e_local == pytest.approx(whole.delta_e_mean)


def test_rmse_and_psnr_are_in_units_of_255():
    metrics = compare(Picture(A * 0, HEAD), Picture(A * 0 + np.float32(0.1), HEAD))
    assert metrics.image_rmse == pytest.approx(25.5, rel=1e-6)
    assert metrics.psnr == pytest.approx(20, rel=1e-6)


def test_display_clips_and_encodes():
    np.testing.assert_allclose(display(np.float32([-1, 0, 0.21404114, 1, 9])), [0, 0, 0.5, 1, 1], atol=1e-6)


def test_a_crop_holds_the_head_and_little_else():
    coverage = np.zeros((100, 80), np.float32)
    coverage[40:60, 30:50] = 1
    rows, columns = head_crop(coverage)
    assert (rows.start, rows.stop, columns.start, columns.stop) == (28, 72, 18, 62)
    assert head_crop(coverage * 0) == (slice(0, 100), slice(0, 80))
