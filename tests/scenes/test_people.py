"""People differ in sex, age, colours and proportions; a seed is one person."""

import numpy as np
import pytest

from scenes.face.head import build_head
from scenes.face.identity import bent, proportions, shaped
from scenes.face.shapes import shape_deltas
from scenes.face.traits import traits

SEEDS = range(200)


def test_a_seed_is_one_person():
    first, again, other = traits(5), traits(5), traits(6)
    np.testing.assert_equal(first._asdict(), again._asdict())
    assert not np.array_equal(first.skin, other.skin)


def test_people_are_of_both_sexes_of_all_ages_and_of_every_skin():
    people = [traits(seed) for seed in SEEDS]
    female, age, melanin = (np.array([getattr(one, name) for one in people]) for name in ("female", "age", "melanin"))
    assert 0.35 < female.mean() < 0.65
    assert age.min() < 26
    assert age.max() > 62
    assert melanin.min() < 0.1
    assert melanin.max() > 0.9


def test_numbers_of_a_person_are_in_their_ranges():
    for one in map(traits, SEEDS):
        for colour in (one.skin, one.lip, one.iris, one.hair):
            assert 0 < colour.min() <= colour.max() < 1
        for share in (one.freckles, one.beard, one.melanin, one.worn):
            assert 0 <= share <= 1


def test_darker_skin_is_darker_and_women_have_no_beard():
    people = sorted(map(traits, SEEDS), key=lambda one: one.melanin)
    assert (np.diff([one.skin.sum() for one in people]) <= 0).all()
    assert max(one.beard for one in people if one.female) == 0


@pytest.fixture(scope="module")
def sculpt():
    head = build_head()
    return head, shape_deltas(head)


def test_the_first_person_has_the_sculpts_head(sculpt):
    head, deltas = shaped(*sculpt, traits(0))
    assert head is sculpt[0]
    assert deltas is sculpt[1]


@pytest.mark.parametrize("seed", [2, 10, 18])
def test_another_head_is_whole_and_moves_where_the_sculpt_moves(sculpt, seed):
    head, deltas = shaped(*sculpt, traits(seed))
    before, after = (
        np.cross(*edges(vertices, head.topology.faces)) for vertices in (sculpt[0].vertices, head.vertices)
    )
    assert (np.einsum("ij,ij->i", before, after) >= 0).mean() > 0.9995, "faces turn over"
    assert 0.05 < np.linalg.norm(head.vertices - sculpt[0].vertices, axis=1).mean() < 1
    still = (sculpt[1] == 0).all(axis=2)
    assert (deltas[still] == 0).all()
    assert np.abs(deltas - sculpt[1]).max() < 0.35 * np.abs(sculpt[1]).max()


def edges(vertices, faces):
    a, b, c = vertices.astype(np.float64)[faces].transpose(1, 0, 2)
    return b - a, c - a


def test_proportions_are_the_same_on_both_sides():
    points, mirror = (
        np.random.default_rng(0).uniform(-8, 8, (500, 3)).astype(np.float32),
        np.array([-1, 1, 1], np.float32),
    )
    amounts = proportions(traits(3))
    np.testing.assert_allclose(bent(points * mirror, amounts), bent(points, amounts) * mirror, atol=1e-5)
