"""References: small, whole, read back as they were, refused when they are something else."""

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from render.exr import write_exr
from render.plugin.reference import Reference
from tests.render.plugin.conftest import renders


def test_it_reads_back_as_it_was(reference, tmp_path):
    reference.write(tmp_path / "a.exr", {"test": "a::b"})
    read = Reference.read(tmp_path / "a.exr")
    np.testing.assert_array_equal(read.mean, reference.mean)
    np.testing.assert_array_equal(read.error, reference.error)
    assert (read.renders, read.spreads) == (reference.renders, reference.spreads)
    test = renders(range(40, 44))
    assert read.compare(test).probability == reference.compare(test).probability
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


def test_the_same_renders_give_the_same_bytes(reference, tmp_path):
    for name in "ab":
        Reference.of(renders(range(32))).write(tmp_path / name, {})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_mean_and_error_are_those_of_the_renders(reference):
    stack = renders(range(32)).astype(np.float64)
    np.testing.assert_allclose(reference.mean, stack.mean(axis=0), rtol=1e-3, atol=1e-7)
    np.testing.assert_allclose(reference.error, stack.std(axis=0, ddof=1) / np.sqrt(32), rtol=1e-3, atol=1e-7)


def test_too_few_renders_are_refused():
    with pytest.raises(FaceZipError, match="at least 8 independent renders") as caught:
        Reference.of(renders(range(3)))
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_another_image_or_a_damaged_one_is_no_reference(reference, tmp_path):
    write_exr(tmp_path / "other.exr", {"mean": reference.mean}, {})
    reference.write(tmp_path / "cut.exr", {})
    (tmp_path / "cut.exr").write_bytes((tmp_path / "cut.exr").read_bytes()[:-200])
    for name in ("other.exr", "cut.exr"):
        with pytest.raises(FaceZipError, match=name) as caught:
            Reference.read(tmp_path / name)
        assert caught.value.code is ErrorCode.UNREADABLE_IMAGE


def test_brighter_than_a_half_float_holds_is_no_error(tmp_path):
    stack = renders(range(8)) * np.float32(1e6)
    reference = Reference.of(stack)
    assert np.isfinite(reference.mean).all()
    assert reference.compare(stack).probability == 1
