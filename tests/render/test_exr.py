import numpy as np
import pytest

from facezip import FaceZipError
from render.exr import read_exr, write_exr


def test_parts_come_back_in_order_as_halves(tmp_path):
    rng = np.random.default_rng(0)
    parts = {name: rng.random((9, 7, 4)).astype(np.float32) for name in ("original", "2 pack", "1 <b>&ü")}
    write_exr(tmp_path / "a.exr", parts, {"view": "front"})
    back = read_exr(tmp_path / "a.exr")
    assert list(back) == list(parts)
    for name, image in parts.items():
        np.testing.assert_array_equal(back[name], image.astype(np.float16))


def test_a_missing_or_damaged_file_is_refused(tmp_path):
    with pytest.raises(FaceZipError, match="no such image"):
        read_exr(tmp_path / "a.exr")
    (tmp_path / "a.exr").write_bytes(b"v/1\x01" + b"\x00" * 40)
    with pytest.raises(FaceZipError, match="not a readable"):
        read_exr(tmp_path / "a.exr")
