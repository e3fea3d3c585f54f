"""Strain of the skin: laws of the tensors at vertices."""

import numpy as np
import pytest

from facezip.rigging.strain import TENSOR, strains
from tests.facezip.rigging.case import sheet


@pytest.fixture(scope="module")
def mesh():
    vertices, topology = sheet()
    return vertices.astype(np.float32), topology.faces


def turned(rng):
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


def test_motion_of_the_whole_head_strains_nothing(mesh):
    vertices, faces = mesh
    moved = (vertices @ turned(np.random.default_rng(0)).T + [1, 2, 3]).astype(np.float32)
    assert np.abs(strains(vertices, moved[None], faces)).max() < 1e-4


@pytest.mark.parametrize(("factor", "part"), [(0.8, slice(0, TENSOR)), (1.3, slice(TENSOR, None))])
def test_a_head_of_another_size_is_strained_alike_everywhere(mesh, factor, part):
    """Each of the two directions by 1 - factor: a tensor of the norm √2 |1 - factor|, compression or stretch alone."""
    vertices, faces = mesh
    found = strains(vertices, (factor * vertices)[None], faces)[:, 0]
    np.testing.assert_allclose(np.linalg.norm(found[:, part], axis=1), np.sqrt(2) * abs(factor - 1), rtol=0.1)
    assert np.abs(np.delete(found, part, axis=1)).max() < 0.02


def test_products_do_not_depend_on_how_the_head_stands(mesh):
    vertices, faces = mesh
    rng = np.random.default_rng(1)
    poses = vertices + 0.02 * rng.standard_normal((3, *vertices.shape)).astype(np.float32)
    turn = turned(rng).astype(np.float32)
    one, other = strains(vertices, poses, faces), strains(vertices @ turn.T, poses @ turn.T, faces)
    products = [found @ np.swapaxes(found, 1, 2) for found in (one, other)]
    np.testing.assert_allclose(*products, atol=2e-3 * np.abs(products[0]).max())


def test_the_unit_does_not_matter(mesh):
    vertices, faces = mesh
    poses = vertices + 0.02 * np.random.default_rng(2).standard_normal((2, *vertices.shape)).astype(np.float32)
    one, other = strains(vertices, poses, faces), strains(10 * vertices, 10 * poses, faces)
    np.testing.assert_allclose(one, other, atol=1e-4)


def test_folded_and_flat_triangles_have_a_finite_strain(mesh):
    vertices, faces = mesh
    assert np.isfinite(strains(vertices, np.zeros((1, *vertices.shape), np.float32), faces)).all()
    flat = vertices.copy()
    flat[faces[0]] = flat[faces[0, 0]]
    assert np.isfinite(strains(flat, vertices[None], faces)).all()
