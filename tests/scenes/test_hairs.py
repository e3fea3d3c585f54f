"""Hair grows where it should, and covers as much on small textures as on large ones."""

import numpy as np
import pytest

from scenes.face.head import build_head
from scenes.face.sculpt import EYE
from scenes.face.skin.hairs import grown
from scenes.face.skin.sampling import TexelGrid, closed
from scenes.face.skin.zones import beard, brow, lips
from scenes.face.traits import traits

HEAD = build_head()


def positions(side):
    """``(R, R, 3)``, cm, of texel centres, to the nearest vertex."""
    texels = TexelGrid.of(HEAD, side)
    return closed(HEAD, HEAD.vertices)[texels.row_of.round().astype(int)][:, texels.column_of.round().astype(int)]


def zone(side, inside):
    return np.array([[inside(*map(float, point)) for point in row] for row in positions(side)])


@pytest.fixture(scope="module")
def man():
    return grown(HEAD, TexelGrid.of(HEAD, 256), traits(0))


@pytest.fixture(scope="module")
def brows():
    return zone(256, lambda x, y, z: z > 3 and brow(x, y, 1.0, 0.0)[0] > 0.8)


def test_a_texel_is_covered_by_a_share(man):
    assert man.dtype == np.float32
    assert man.min() == 0
    assert 0.5 < man.max() <= 1


def test_hair_is_the_same_to_the_byte(man):
    np.testing.assert_array_equal(grown(HEAD, TexelGrid.of(HEAD, 256), traits(0)), man)


def test_brows_are_dense_and_foreheads_bare(man, brows):
    bare = zone(256, lambda x, y, z: z > 7 and 4.2 < y < 6.2)
    assert man[brows].mean() > 0.3
    assert man[bare].mean() < 0.002


def test_a_beard_is_a_mans(man):
    where = zone(256, lambda x, y, z: beard(x, y, z) > 0.6)
    assert man[where].mean() > 0.02
    assert grown(HEAD, TexelGrid.of(HEAD, 256), traits(18))[where].mean() < 0.002


def test_no_hair_grows_on_lips_and_in_pupils(man):
    pupil = zone(256, lambda x, y, z: z > 6 and np.hypot(abs(x) - EYE[0], y - EYE[1]) < 0.12)
    mouth = zone(256, lambda x, y, z: lips(x, y, z) > 0.95)
    assert pupil.any()
    assert man[pupil].max() == 0
    assert man[mouth].mean() < 0.01


def test_a_small_texture_is_covered_as_much_as_a_large_one(man, brows):
    fine = grown(HEAD, TexelGrid.of(HEAD, 512), traits(0)).reshape(256, 2, 256, 2).mean(axis=(1, 3))
    scalp = np.s_[10:50]
    assert fine[scalp].mean() == pytest.approx(man[scalp].mean(), rel=0.1)
    assert fine[brows].mean() == pytest.approx(man[brows].mean(), rel=0.15)
