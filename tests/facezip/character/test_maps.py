import numpy as np
import pytest

from facezip.character.maps import KNOWN, Map, angles, is_map_name, normals_of
from facezip.character.neutrals import packed_neutral, unpacked_neutral

KINDS = [*KNOWN.values(), Map("displacement", "data", -3.0, 5.0)]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_texels_stand_for_the_values(kind):
    rng = np.random.default_rng(0)
    if kind.is_normal:
        values = normals_of(rng.uniform(-5, 5, (40, 40, 2)).astype(np.float32))
    else:
        values = rng.uniform(kind.low, kind.high, (40, 40, 3)).astype(np.float32)
    texels = kind.encode(values)
    assert texels.min() >= 0
    assert texels.max() <= 1
    np.testing.assert_allclose(kind.decode(texels), values, atol=1e-5)


def test_slopes_add_as_the_heights_of_surfaces_do():
    y, x = np.mgrid[:32, :32].astype(np.float32)
    one, other = 0.1 * np.sin(x / 3), 0.2 * np.cos(y / 4) * np.sin(x / 7)

    def normals(heights):
        across, down = np.gradient(heights, axis=1), np.gradient(heights, axis=0)
        return normals_of(np.stack([-across, -down], axis=2))

    normal = KNOWN["normal"]
    flat = normal.encode(normals(np.zeros_like(x)))
    summed = normal.encode(normals(one)) + normal.encode(normals(other)) - flat
    assert angles(normal.decode(summed), normals(one + other)).max() < 0.01


def test_angles_are_exact_from_thousandths_of_a_degree_on():
    for degrees in (0, 0.001, 0.1, 30, 180):
        turned = np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))], np.float32)
        assert angles(np.array([0, 0, 1], np.float32), turned) == pytest.approx(degrees, abs=2e-5, rel=1e-3)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
@pytest.mark.parametrize("bits", [8, 16])
def test_a_stored_neutral_comes_back_and_stays(kind, bits):
    rng = np.random.default_rng(1)
    texels = rng.uniform(0.45, 0.55, (16, 16, 2 if kind.is_normal else 3)).astype(np.float32)
    stored = packed_neutral(texels, kind, bits)
    assert stored.dtype == f"uint{bits}"
    again = packed_neutral(unpacked_neutral(stored, kind), kind, bits)
    across = again[..., :2] if kind.is_normal else again
    np.testing.assert_array_equal(across, stored[..., : across.shape[2]])


def test_map_names_are_safe_in_file_names():
    assert is_map_name("micro_normal2")
    for name in ("", "Normal", "a.b", "../a", "weights", "mask", "a" * 33, 3):
        assert not is_map_name(name)
