"""Where arrays live changes how much memory an export or a decompression takes, and nothing else."""

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.errors import ErrorCode
from facezip.export import TARGETS
from facezip.machine import memory
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import ALBEDO_KEY
from tests.facezip.export.conftest import KINDS, files_of, layered_model, smooth_model, with_part
from tests.peaks import peak_of


@pytest.fixture(scope="module")
def layered(tmp_path_factory):
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    model = layered_model(smooth_model, (KINDS[0], KINDS[2], KINDS[3]), tiles=(1001, 1002), side=40, weights=5)
    write_pack(model, path)
    return path


@pytest.mark.parametrize(("textures", "maps"), [("png", "together"), ("dds", "together"), ("ktx2", "apart")])
def test_a_streamed_export_has_the_bytes_of_one_made_in_memory(layered, textures, maps, tmp_path, monkeypatch):
    TARGETS["godot"](layered, tmp_path / "here", textures=textures, maps=maps)
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(10**6, tmp_path):
        TARGETS["godot"](layered, tmp_path / "streamed", textures=textures, maps=maps)
    assert files_of(tmp_path / "streamed") == files_of(tmp_path / "here")


def test_a_streamed_blend_is_the_one_made_in_memory(layered, tmp_path, monkeypatch):
    def blends():
        model = read_pack(layered)
        return [model.blend({"expr_0": 0.7}, *key) for key in model.parts]

    here = blends()
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(10**6, tmp_path):
        for ours, theirs in zip(blends(), here, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def write_large(path, channels, slots):
    """A pack of one albedo, of the same texels again and again."""
    model, times = smooth_model(side=64, weights=8, expressions=8, slots=slots), 24
    part = model.parts[ALBEDO_KEY]
    neutral = np.tile(part.neutral[..., :channels], (times, times, 1))
    write_pack(with_part(model, neutral, np.tile(part.differences[..., :channels], (1, times, times, 1))), path)


# Of an export little to code, and of a decompression much to hold.
@pytest.mark.parametrize(
    ("channels", "slots", "limit", "line"),
    [(1, 2, 430, "export --to godot --textures dds"), (3, 8, 470, "decompress --expression expr_0")],
    ids=["export", "decompress"],
)
def test_a_limit_is_kept_where_a_run_without_it_takes_more(channels, slots, limit, line, tmp_path):
    write_large(tmp_path / "me.facezip", channels, slots)
    verb, *options = line.split()
    call = (verb, tmp_path / "me.facezip", *options, "-o", tmp_path / "out", "--overwrite")
    in_memory, whole = peak_of(*call)
    here = files_of(tmp_path / "out")
    streamed, same = peak_of(*call, "--memory", f"{limit}M")
    assert streamed < 1e6 * limit < in_memory
    assert same == whole
    assert files_of(tmp_path / "out") == here


@pytest.mark.parametrize("work", [lambda pack, out: TARGETS["godot"](pack, out), lambda pack, _: read_pack(pack)])
def test_a_limit_that_is_too_small_names_the_least_that_works(layered, work, tmp_path):
    with memory.limited(10**6, tmp_path), pytest.raises(FaceZipError, match=r"need \d+M at least") as refusal:
        work(layered, tmp_path / "out")
    assert refusal.value.code is ErrorCode.BAD_VALUE
    assert not (tmp_path / "out").exists()
