"""The estimator of generated shapes: exact where its model is true, none where there is no evidence."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip.fit.methods import compress
from facezip.rigging.evidence import STEPS, STRENGTHS, _keep_zero, estimate, wiener
from facezip.rigging.fit import fit_rig
from facezip.rigging.likeness import Likeness, Poses
from facezip.rigging.shown import shown
from tests.facezip.rigging.case import SHAPES, make_case

TINY = 1e-12


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def rig(case):
    meshes = case.scans.meshes
    return fit_rig(meshes.neutral, meshes.deltas, meshes.topology.faces, case.template.neutral, case.template.deltas)


@pytest.fixture(scope="module")
def model(case):
    return compress(case.scans)


def poses_of(scans, rig, order=slice(None)):
    meshes = scans.meshes
    return Poses.of(meshes.neutral, meshes.deltas, rig.deltas, meshes.topology.faces, rig.weights[order])


def likeness_of(rng, scans=6, shapes=4, places=1):
    """Of random strains, shapes and scans alike."""
    strain = rng.standard_normal((places, scans + shapes, 8))
    covariance = strain @ np.swapaxes(strain, 1, 2)
    variances = np.einsum("tmm->tm", covariance[:, scans:, scans:])
    return Likeness(covariance[:, :scans, :scans], covariance[:, scans:, :scans], variances), covariance


@settings(deadline=None)
@given(st.integers(0, 2**16), st.sampled_from(STRENGTHS[3:]))
def test_shrinkage_is_the_conditional_mean_of_the_gaussian_case(seed, strength):
    """With a neutral as noisy as the scans, spelled out over scans, neutral and shape."""
    rng = np.random.default_rng(seed)
    likeness, covariance = likeness_of(rng)
    count = likeness.scans.shape[1]
    noisy = strength * covariance[0, :count, :count] + np.eye(count) + np.ones((count, count))
    made = wiener(likeness, noisy[None], TINY)
    ratio = made.strength[0]
    exact = (
        ratio * likeness.between[0] @ np.linalg.inv(ratio * likeness.scans[0] + np.eye(count) + np.ones((count, count)))
    )
    np.testing.assert_allclose(made.shares[0], exact, atol=1e-9)
    left = ratio * likeness.shapes[0] - ratio * np.einsum("mn,mn->m", exact, likeness.between[0])
    np.testing.assert_allclose(made.evidence[0], 1 - left / (ratio * likeness.shapes[0]), atol=1e-9)


def test_strength_and_noise_are_found_where_the_products_are_those_of_the_model():
    """The likeliest of the strengths is the one that made them."""
    likeness, covariance = likeness_of(np.random.default_rng(0))
    count = likeness.scans.shape[1]
    for strength in STRENGTHS[4:]:
        products = 0.01 * (strength * covariance[:, :count, :count] + np.eye(count) + 1)
        made = wiener(likeness, products, TINY)
        assert made.strength[0] == strength
        np.testing.assert_allclose(made.variance[0], 0.01 * strength * likeness.shapes[0])


def test_scans_that_show_nothing_but_noise_change_no_shape():
    likeness, _ = likeness_of(np.random.default_rng(1))
    count = likeness.scans.shape[1]
    made = wiener(likeness, (np.eye(count) + 1)[None], TINY)
    assert made.strength[0] == 0
    assert not made.shares.any()
    assert not made.evidence.any()


def test_noise_below_rounding_is_no_evidence():
    likeness, covariance = likeness_of(np.random.default_rng(2))
    count = likeness.scans.shape[1]
    assert wiener(likeness, 1e-9 * covariance[:, :count, :count], 1.0).strength[0] == 0


def test_more_noise_makes_a_smaller_change():
    likeness, covariance = likeness_of(np.random.default_rng(3))
    count = likeness.scans.shape[1]
    sizes = [
        np.abs(wiener(likeness, covariance[:, :count, :count] + noise * (np.eye(count) + 1), TINY).shares).sum()
        for noise in (1e-3, 1.0, 1e3)
    ]
    assert sizes == sorted(sizes, reverse=True)


def test_a_shape_that_strains_nothing_gets_nothing(case, rig, model):
    still = replace(rig, deltas=np.concatenate([np.zeros_like(rig.deltas[:1]), rig.deltas[1:]]))
    made = estimate(case.scans, poses_of(case.scans, still), model.weights)[1001]
    # The smallest weight of a slot may be widened by a step of 8 bits.
    step = np.ptp(made.weights, axis=(0, 1, 2)).max() / STEPS
    assert np.abs(made.weights[0]).max() <= step
    assert made.expected[0].max() < 1e-9


def test_no_change_is_stored_as_no_change(case, rig, model):
    made = estimate(case.scans, poses_of(case.scans, rig), model.weights)[1001]
    low, high = made.weights.min(axis=(0, 1, 2)), made.weights.max(axis=(0, 1, 2))
    zero = STEPS * -low.astype(float) / (high - low)
    np.testing.assert_allclose(zero, np.rint(zero), atol=1e-3)


@given(low=st.floats(2**-10, 2**10), ratio=st.floats(1e-6, 1e6), others=st.lists(st.floats(0, 1), max_size=4))
def test_zero_is_kept_whatever_the_range_by_a_wider_one(low, ratio, others):
    high = low * ratio
    weights = np.array([-low, high, 0, *(high * share - low * (1 - share) for share in others)], np.float32)
    kept = weights.copy()
    _keep_zero(kept)
    step = np.ptp(kept).astype(float) / STEPS
    zero = -kept.min().astype(float) / step
    assert abs(zero - np.rint(zero)) < 1e-3
    assert kept.min() <= 0.9999 * weights.min()
    assert kept.max() >= 0.9999 * weights.max()
    assert np.ptp(kept) <= 2.001 * np.ptp(weights)
    assert (kept != weights).sum() <= 1


def test_the_order_of_the_scans_does_not_matter(case, rig, model):
    order = [2, 0, 3, 1]
    scans = case.scans
    stack = scans.first
    shuffled = replace(
        scans,
        expressions=tuple(scans.expressions[n] for n in order),
        meshes=replace(scans.meshes, vertices=scans.meshes.vertices[order]),
        stacks={key: replace(stack, textures=stack.textures[order]) for key in scans.stacks},
    )
    one = estimate(scans, poses_of(scans, rig), model.weights)[1001]
    other = estimate(shuffled, poses_of(shuffled, rig, order), {1001: model.weights[1001][order]})[1001]
    np.testing.assert_allclose(one.weights, other.weights, atol=1e-4 * np.abs(one.weights).max())
    np.testing.assert_allclose(one.evidence, other.evidence, atol=1e-4)


def test_the_same_input_gives_the_same_bits(case, rig, model):
    first, second = (estimate(case.scans, poses_of(case.scans, rig), model.weights)[1001] for _ in range(2))
    for one, other in zip(vars(first).values(), vars(second).values(), strict=True):
        assert np.array_equal(one, other)


def test_what_is_shown_lies_between_none_and_all_as_a_whole_and_by_region(case, rig, model):
    facts = shown(estimate(case.scans, poses_of(case.scans, rig), model.weights), SHAPES)
    assert tuple(facts) == SHAPES
    for found in facts.values():
        assert 0 <= found.shown <= 1
        assert found.uncertainty >= 0
        for region in found.regions:
            assert 0 <= region.shown <= 1
            assert (np.diff([region.u, region.v]) == 0.25).all()
