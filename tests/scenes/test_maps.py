import numpy as np
import pytest

from facezip.character.maps import angles
from facezip.character.tiles import FIRST_TILE
from facezip.errors import FaceZipError
from scenes.character import Person, captures, make_character
from scenes.face.capture import MAPS, Nuisances, captured
from scenes.face.expressions import EXPRESSIONS


@pytest.fixture(scope="module")
def surface():
    return make_character(128, 3, maps=MAPS[:2])


def test_its_albedo_is_the_embedded_characters(surface):
    np.testing.assert_array_equal(surface.first.textures, make_character(128, 3).first.textures)


def test_without_nuisances_the_maps_are_the_truth():
    surface, person = make_character(128, 2, nuisances=0, maps=MAPS), Person.make(128)
    assert tuple(kind.name for kind in surface.maps[1:]) == MAPS
    for name in surface.expressions:
        truth = person.relief(EXPRESSIONS[name])
        for kind in surface.maps[1:]:
            seen = surface.texture(name, kind.name)
            if kind.is_normal:
                p, q = np.moveaxis(truth.slopes, 2, 0)
                expected = np.stack([p, q, np.ones_like(p)], 2) / np.sqrt(1 + p**2 + q**2)[..., None]
                assert angles(seen, expected.astype(np.float32)).max() < 0.6
            else:
                assert np.abs(seen - getattr(truth, kind.name)).max() < 0.6 / 255


@pytest.mark.parametrize("name", MAPS)
def test_a_map_does_not_depend_on_which_others_there_are(name):
    alone, among = make_character(64, 2, maps=(name,)), make_character(64, 2, maps=MAPS)
    assert [kind.name for kind in alone.maps] == ["albedo", name]
    np.testing.assert_array_equal(alone.stacks[name, FIRST_TILE].neutral, among.stacks[name, FIRST_TILE].neutral)
    np.testing.assert_array_equal(alone.stacks[name, FIRST_TILE].textures, among.stacks[name, FIRST_TILE].textures)


def test_a_map_that_there_is_not_is_refused():
    with pytest.raises(FaceZipError, match="gloss"):
        make_character(64, 2, maps=("normal", "gloss"))


def test_further_maps_of_a_capture_are_misregistered_as_its_albedo_is():
    person, named = Person.make(64), {"smile": EXPRESSIONS["smile"], "frown": EXPRESSIONS["frown"]}
    for albedo, posed, again in captures(person, named, 1.0):
        repeated = captured(posed.texture, Nuisances(), again, registered=not posed.weights)
        np.testing.assert_array_equal(np.rint(repeated * 255), albedo)


def test_folds_tilt_normals_where_they_darken_the_skin(surface):
    exact = make_character(256, 4, nuisances=0, maps=MAPS[:2])
    normal, albedo = (exact.stacks[name, FIRST_TILE] for name in ("normal", "albedo"))
    n = exact.expressions.index("frown")
    dark = (albedo.neutral.astype(float) - albedo.textures[n]).mean(axis=2)
    tilt = np.abs(normal.textures[n].astype(float) - normal.neutral).sum(axis=2)
    deep = dark > np.quantile(dark, 0.995)
    assert tilt[deep].mean() > 8 * tilt[~deep].mean()


def test_tiles_hold_the_same_texels():
    cut = make_character(128, 2, tiles=(2, 2), maps=MAPS[:2])
    whole = make_character(128, 2, maps=MAPS[:2])
    np.testing.assert_array_equal(
        cut.stacks["normal", 1012].textures, whole.stacks["normal", FIRST_TILE].textures[:, :64, 64:]
    )
