import pytest

from render.documents.images import ErrorPlace, ImageMetrics, PackRender, Render
from render.limits import Limit, Thresholds
from render.verdict import verdict

LIMITS = Thresholds(Limit(1.0, 2.0, 0.05), Limit(3.0, 6.0, 0.10))


def render(name, delta_e, flip, decided=True, local=0):
    level = LIMITS.level(delta_e, local, flip)
    metrics = ImageMetrics(
        image_rmse=1, psnr=48, flip=flip, delta_e_mean=0, delta_e_p95=delta_e, delta_e_local=local, ssim=1
    )
    where = ErrorPlace(region="mouth", delta_e_p95=delta_e, box=(0, 0, 8, 8)) if delta_e else None
    numbers = PackRender(
        **vars(metrics), level=level, decided=decided, interval={}, image_rmse_debiased=1, regions={}, where=where
    )
    look = {"expression": name, "view": "close_up", "light": "side"}
    return Render(**look, spp=64, noise_floor=metrics, packs=[numbers], exr=f"{name}.exr")


@pytest.mark.parametrize(
    ("delta_e", "flip", "level"),
    [
        (0, 0, "identical"), (1e-9, 0, "indistinguishable"), (1.0, 0.05, "indistinguishable"),
        (1.01, 0.01, "visible"), (0.1, 0.051, "visible"), (3.0, 0.1, "visible"), (3.01, 0.01, "fails"),
        (0.5, 0.11, "fails"),
    ],
)  # fmt: skip
def test_a_level_begins_where_the_one_before_ends(delta_e, flip, level):
    assert LIMITS.level(delta_e, 0, flip) == level


@pytest.mark.parametrize(
    ("local", "level"), [(1e-9, "indistinguishable"), (2, "indistinguishable"), (2.01, "visible"), (6.01, "fails")]
)
def test_a_small_place_is_enough(local, level):
    assert LIMITS.level(0, local, 0) == level


def test_the_worst_render_is_named_with_its_place():
    level, sentence = verdict(0, [render("smile", 0.5, 0.01), render("anger", 2.0, 0.02)], LIMITS)
    assert level == "visible"
    assert sentence.startswith("Visible at anger, close up view, side light, most on the mouth: dE2000 2")
    assert "1 of 2 renders" in sentence


def test_a_high_flip_counts_where_colours_are_close():
    level, sentence = verdict(0, [render("smile", 0.9, 0.01), render("anger", 0.5, 0.2)], LIMITS)
    assert level == "fails"
    assert "anger" in sentence


def test_every_level_says_what_it_is():
    words = {"identical": (0, 0), "indistinguishable": (0.5, 0.01), "visible": (2, 0.01), "fails": (5, 0.01)}
    for level, errors in words.items():
        found, sentence = verdict(0, [render("smile", *errors)], LIMITS)
        assert found == level
        assert sentence.lower().startswith(level)


def test_doubt_is_said():
    assert "too close to the limit to tell with 64" in verdict(0, [render("smile", 1.01, 0.01, False)], LIMITS)[1]


def test_at_most_is_over_all_renders():
    """The render that is worst as a whole need not be the worst of every metric."""
    renders = [render("smile", 0.9, 0.01, local=0.5), render("laugh", 0.2, 0.03, local=1.5)]
    sentence = verdict(0, renders, LIMITS)[1]
    assert "at most dE2000 0.9 at the 95th percentile and 1.5 in the worst place, FLIP 0.03" in sentence
