"""Weight maps of generated shapes: constraint (10), sparsity in place, and packs that blend."""

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.rigging.activity import activity
from facezip.rigging.fit import fit_rig
from facezip.rigging.rigged import MAPS, rigged
from facezip.rigging.weightmaps import DAMPINGS, Examples, GeometryAware, pseudo_inverse
from tests.facezip.rigging.case import SHAPES, make_case

SIZE = (6, 8)


@pytest.fixture
def example_weights():
    return np.random.default_rng(0).uniform(0, 1, (5, 12))


@pytest.fixture
def weights():
    return np.random.default_rng(1).standard_normal((5, *SIZE, 4)).astype(np.float32)


@pytest.fixture
def moving():
    return np.random.default_rng(2).uniform(0, 1, (*SIZE, 12)).astype(np.float32)


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def rig(case):
    scans, template = case.scans, case.template
    moved = scans.meshes.vertices - scans.meshes.neutral
    return fit_rig(scans.meshes.neutral, moved, scans.meshes.topology.faces, template.neutral, template.deltas)


def test_pseudo_inverse_gives_the_scans_maps_back(example_weights, weights):
    generated = pseudo_inverse(weights, Examples.of(example_weights))
    assert np.allclose(np.tensordot(example_weights, generated, 1), weights, atol=1e-5)


def test_geometry_aware_gives_the_scans_maps_back_without_damping(example_weights, weights, moving):
    generated = GeometryAware(Examples.of(example_weights), moving).maps(weights, 0.0)
    assert np.allclose(np.tensordot(example_weights, generated, 1), weights, atol=1e-4)


def test_equal_activity_is_the_pseudo_inverse(example_weights, weights, moving):
    examples = Examples.of(example_weights)
    generated = GeometryAware(examples, np.ones_like(moving)).maps(weights, 0.0)
    assert np.allclose(generated, pseudo_inverse(weights, examples), atol=1e-4)


def test_a_shape_that_moves_nothing_gets_nothing(example_weights, weights, moving):
    moving[..., 3] = 0
    generated = GeometryAware(Examples.of(example_weights), moving).maps(weights, 0.1)
    assert np.abs(generated[3]).max() < 1e-2 * np.abs(generated).max()


def test_more_damping_makes_smaller_maps(example_weights, weights, moving):
    aware = GeometryAware(Examples.of(example_weights), moving)
    sizes = [np.abs(aware.maps(weights, damping)).mean() for damping in (0.0, *DAMPINGS)]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(("noise", "least", "most"), [(0.0, DAMPINGS[0], DAMPINGS[0]), (50.0, 1.0, DAMPINGS[-1])])
def test_damping_grows_with_the_noise_of_the_scans(moving, noise, least, most):
    """Maps that shapes explain need the least, maps of noise much."""
    rng = np.random.default_rng(3)
    example_weights = rng.uniform(0, 1, (12, 3))
    true = moving[..., :3].transpose(2, 0, 1)[..., None] * rng.standard_normal(4)
    clean = np.tensordot(example_weights, true, 1)
    aware = GeometryAware(Examples.of(example_weights), moving[..., :3])
    chosen = aware.best_damping((clean + noise * rng.standard_normal(clean.shape)).astype(np.float32), np.ones(4))
    assert least <= chosen <= most


def test_scans_that_are_alike_are_cut_and_reported(example_weights, weights):
    example_weights[4] = example_weights[3] + 1e-6
    examples = Examples.of(example_weights)
    assert examples.condition > 1e4
    assert len(examples.weights) == 4
    assert np.abs(pseudo_inverse(weights, examples)).max() < 100


def test_activity_is_where_a_shape_moves(case):
    moving = activity(case.scans.meshes.topology, case.deltas, (16, 16))
    rows = [np.unravel_index(moving[..., m].argmax(), (16, 16))[0] for m in (0, 3)]
    assert moving.shape == (16, 16, len(SHAPES))
    assert rows[0] < 6
    assert rows[1] > 9


@pytest.mark.parametrize("maps", MAPS)
def test_a_rigged_pack_holds_the_shapes_and_blends_them(case, rig, maps, tmp_path):
    made = rigged(compress(case.scans), rig, SHAPES, maps).model
    write_pack(made, tmp_path / "sheet.facezip")
    model = read_pack(tmp_path / "sheet.facezip")
    assert model.expressions == SHAPES
    assert np.array_equal(model.meshes.deltas, rig.deltas)
    # Equation (12), spelled out, where nothing is clipped.
    blend, brow, jaw = (model.blend(one) for one in ({"brow": 0.5, "jaw": 0.25}, {"brow": 1.0}, {"jaw": 1.0}))
    free = np.logical_and.reduce([(texture > 0) & (texture < 1) for texture in (blend, brow, jaw)])
    expected = model.neutral + 0.5 * (brow - model.neutral) + 0.25 * (jaw - model.neutral)
    assert free.mean() > 0.5
    assert np.allclose(blend[free], expected[free], atol=1e-5)


def test_a_weight_that_is_no_number_and_a_shape_that_is_unknown_are_named(case, rig):
    made = rigged(compress(case.scans), rig, SHAPES).model
    for blend, code in (({"jawOpen": 1.0}, ErrorCode.UNKNOWN_NAME), ({"jaw": float("nan")}, ErrorCode.BAD_VALUE)):
        with pytest.raises(FaceZipError, match=next(iter(blend))) as caught:
            made.blend(blend)
        assert caught.value.code is code


def test_geometry_aware_maps_need_weights_that_vary(case, rig):
    with pytest.raises(FaceZipError, match="uniform") as caught:
        rigged(compress(case.scans, "pca"), rig, SHAPES)
    assert caught.value.code is ErrorCode.BAD_VALUE
