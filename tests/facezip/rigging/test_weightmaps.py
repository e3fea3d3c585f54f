"""Weight maps of generated shapes: constraint (10), and packs that blend."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.methods import compress
from facezip.pack.model import Part
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.rigging.fit import fit_rig
from facezip.rigging.rigged import MAPS, rigged
from facezip.rigging.weightmaps import Examples, pseudo_inverse
from tests.facezip.rigging.case import SHAPES, make_case, with_maps

SIZE = (6, 8)


@pytest.fixture
def example_weights():
    return np.random.default_rng(0).uniform(0, 1, (5, 12))


@pytest.fixture
def weights():
    return np.random.default_rng(1).standard_normal((5, *SIZE, 4)).astype(np.float32)


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


def test_scans_that_are_alike_are_cut_and_reported(example_weights, weights):
    example_weights[4] = example_weights[3] + 1e-6
    examples = Examples.of(example_weights)
    assert examples.condition > 1e4
    assert len(examples.weights) == 4
    assert np.abs(pseudo_inverse(weights, examples)).max() < 100


@pytest.fixture(scope="module")
def tiled(case):
    """The same scans with three maps on two tiles, compressed."""
    scans = with_maps(case.scans, (2, 1))
    return scans, compress(scans, differences=3)


@pytest.mark.parametrize("maps", MAPS)
def test_a_rigged_pack_holds_the_shapes_and_blends_them(case, rig, tiled, maps, tmp_path):
    made = rigged(*tiled, rig, SHAPES, maps).model
    write_pack(made, tmp_path / "sheet.facezip")
    model = read_pack(tmp_path / "sheet.facezip")
    assert model.expressions == SHAPES
    size = np.ptp(model.meshes.neutral, axis=0).max()
    np.testing.assert_allclose(model.meshes.deltas, rig.deltas, atol=2e-5 * size)
    assert set(model.parts) == set(tiled[0].stacks)
    for key, part in model.parts.items():
        # Equation (12), spelled out, where nothing is clipped.
        blend, brow, jaw = (model.texels(one, key) for one in ({"brow": 0.5, "jaw": 0.25}, {"brow": 1}, {"jaw": 1}))
        free = np.logical_and.reduce([(texture > 0) & (texture < 1) for texture in (blend, brow, jaw)])
        expected = part.neutral + 0.5 * (brow - part.neutral) + 0.25 * (jaw - part.neutral)
        assert free.mean() > 0.5
        assert np.allclose(blend[free], expected[free], atol=1e-5)


def test_shapes_that_mix_as_a_scan_does_give_all_its_maps_back(rig, tiled):
    """Equation (10) on every map and tile: undamped, a scan is the blend of what it is made of."""
    scans, model = tiled
    made = rigged(scans, model, rig, SHAPES, "pseudo-inverse").model
    for n, name in enumerate(scans.expressions):
        blend = dict(zip(SHAPES, rig.weights[n].tolist(), strict=True))
        for key in scans.stacks:
            np.testing.assert_allclose(made.texels(blend, key), model.texels({name: 1.0}, key), atol=2e-3)


def test_how_a_chart_is_cut_changes_nothing_away_from_the_cut(case, rig):
    """A tile's maps know nothing of where it ends."""
    model = compress(case.scans)
    half = {tile: model.weights[1001][:, :, columns] for tile, columns in ((1001, slice(0, 4)), (1002, slice(4, 8)))}
    cut = with_maps(case.scans, (2, 1)).only("albedo")
    halves = {
        key: Part(*(np.split(values, 2, axis=-2)[key[1] - 1001] for values in (part.neutral, part.differences)))
        for key in cut.stacks
        for part in model.parts.values()
    }
    other = replace(model, parts=halves, weights=half, meshes=cut.meshes)
    whole, parts = rigged(case.scans, model, rig, SHAPES), rigged(cut, other, rig, SHAPES)
    joined = np.concatenate([parts.model.weights[tile] for tile in (1001, 1002)], axis=2)
    assert np.abs(joined - whole.model.weights[1001]).max() < 0.02 * np.abs(joined).max()


def test_a_weight_that_is_no_number_and_a_shape_that_is_unknown_are_named(case, rig):
    made = rigged(case.scans, compress(case.scans), rig, SHAPES).model
    for blend, code in (({"jawOpen": 1.0}, ErrorCode.UNKNOWN_NAME), ({"jaw": float("nan")}, ErrorCode.BAD_VALUE)):
        with pytest.raises(FaceZipError, match=next(iter(blend))) as caught:
            made.blend(blend)
        assert caught.value.code is code


def test_geometry_aware_maps_need_weights_that_vary(case, rig):
    with pytest.raises(FaceZipError, match="uniform") as caught:
        rigged(case.scans, compress(case.scans, "pca"), rig, SHAPES)
    assert caught.value.code is ErrorCode.BAD_VALUE
