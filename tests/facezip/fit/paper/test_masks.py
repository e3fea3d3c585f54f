from dataclasses import replace

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError
from facezip.character.raster import rasterise
from facezip.files.obj import Topology
from facezip.fit.paper.masks import biharmonic, compute_masks, face_region, poisson_disk_samples
from tests.facezip.conftest import ALBEDO_KEY, grid_topology, random_character, with_albedo


def dense(masks):
    return np.stack([masks.dense(k) for k in range(masks.count)])


def masks_of(character, count):
    return compute_masks(character, count, 0)[ALBEDO_KEY]


def with_left_half_shown(character):
    mask = np.zeros(character.first.resolution, np.float32)
    mask[:, : mask.shape[1] // 2] = 1
    return with_albedo(character, mask=mask)


def test_masks_lie_in_0_to_1_and_sum_to_one(character):
    masks = dense(masks_of(character, 12))
    assert masks.min() >= 0
    np.testing.assert_allclose(masks.sum(axis=0), 1, atol=1e-5)


def test_a_mask_is_one_at_its_sample_and_zero_at_the_others(character):
    masks = masks_of(character, 12)
    np.testing.assert_array_equal(masks.values[masks.samples], np.eye(12))


def test_masks_vanish_outside_the_face_region(character):
    shown = with_left_half_shown(character)
    masks = dense(masks_of(shown, 6))
    assert masks[:, :, 20:].max() == 0
    np.testing.assert_allclose(masks.sum(axis=0)[:, :16], 1, atol=1e-5)


def test_biharmonic_functions_reproduce_the_constant_before_clamping():
    """The only mask of a region is one everywhere on it: a constant bends nothing."""
    topology = grid_topology(6)
    vertices = np.c_[topology.uv, np.zeros(36)].astype(np.float32)
    values = biharmonic(vertices, topology.faces, np.ones(36, bool), np.array([7]))
    np.testing.assert_allclose(values, 1, atol=1e-5)


def test_biharmonic_functions_have_the_least_energy():
    """The gradient of ‖Lφ‖² vanishes at free vertices. Between two opposite corners nothing is clamped."""
    side = 5
    topology = grid_topology(side)
    vertices = np.c_[topology.uv, np.zeros(side**2)].astype(np.float32)
    samples = np.array([0, side**2 - 1])
    phi = biharmonic(vertices, topology.faces, np.ones(side**2, bool), samples)[:, 0].astype(float)
    edges = {tuple(sorted(pair)) for f in topology.faces for pair in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))}
    laplacian = np.zeros((side**2, side**2))
    for a, b in edges:
        laplacian[[a, b], [b, a]] -= 1
        laplacian[[a, b], [a, b]] += 1
    gradient = laplacian.T @ laplacian @ phi
    np.testing.assert_allclose(np.delete(gradient, samples), 0, atol=1e-5)


def test_a_part_of_the_face_without_a_sample_joins_the_nearest_mask():
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], np.float32)
    values = biharmonic(vertices, faces, np.ones(6, bool), np.array([0, 1]))
    np.testing.assert_array_equal(values[3:], [[0, 1]] * 3)


def test_masks_do_not_notice_a_uv_seam(character):
    """The same surface with its chart cut in two: equal functions on the vertices."""
    topology = character.meshes.topology
    right = topology.uv[topology.face_uv][:, :, 0].mean(axis=1) > 0.5
    uv = np.concatenate([topology.uv, topology.uv])
    face_uv = topology.face_uv + (len(topology.uv) * right[:, None]).astype(np.int32)
    meshes = replace(character.meshes, topology=Topology(topology.faces, uv, face_uv))
    cut = replace(character, meshes=meshes)
    np.testing.assert_array_equal(masks_of(cut, 8).values, masks_of(character, 8).values)


def test_samples_lie_apart_and_as_far_as_their_number_allows():
    rng = np.random.default_rng(0)
    vertices = rng.random((400, 3)).astype(np.float32)
    vertices[:, 2] = 0
    samples = poisson_disk_samples(vertices, np.ones(400, bool), 20, seed=1)
    assert len(set(samples.tolist())) == 20
    gaps = np.linalg.norm(vertices[samples, None] - vertices[samples], axis=2) + 9 * np.eye(20)
    # Random darts without rejection come about ten times closer.
    assert gaps.min() > 0.1


def test_samples_stay_in_the_region_and_follow_the_seed(character):
    region = np.arange(81) < 40
    first, again, other = (poisson_disk_samples(character.meshes.neutral, region, 8, seed) for seed in (1, 1, 2))
    assert first.max() < 40
    np.testing.assert_array_equal(first, again)
    assert set(first) != set(other)


def test_every_vertex_can_be_a_sample(character):
    masks = masks_of(character, 81)
    np.testing.assert_allclose(dense(masks).sum(axis=0), 1, atol=1e-5)


@pytest.mark.parametrize("count", [82, 5000])
def test_more_masks_than_vertices_are_refused(character, count):
    with pytest.raises(FaceZipError, match=f"--masks {count}: .* 81 distinct") as refused:
        masks_of(character, count)
    assert refused.value.code is ErrorCode.TOO_MANY_MASKS


def test_the_region_is_what_the_mask_shows(character):
    shown = with_left_half_shown(character)
    topology = shown.meshes.topology
    region = face_region(shown, shown.first, rasterise(topology, shown.first.resolution))
    u = topology.uv[:, 0]
    assert region[u <= 0.5].all()
    assert not region[u > 0.625].any()


@pytest.mark.parametrize("side", [32, 37])
def test_small_maps_average_the_blocks_of_texels(side):
    masks = masks_of(random_character(side=side), 6)
    small = masks.downsampled(8)
    assert small.shape == (6, -(-side // 8), -(-side // 8))
    np.testing.assert_allclose(small[:, 1, 2], dense(masks)[:, 8:16, 16:24].mean(axis=(1, 2)), atol=1e-5)
    last = (side - 1) // 8 * 8
    np.testing.assert_allclose(small[:, -1, -1], dense(masks)[:, last:, last:].mean(axis=(1, 2)), atol=1e-5)


def test_small_maps_do_not_fade_at_the_border_of_the_face(character):
    small = masks_of(with_left_half_shown(character), 6).downsampled(8)
    np.testing.assert_allclose(small.sum(axis=0), 1, atol=1e-5)
