"""Where arrays live changes how much memory is taken, and nothing else."""

import errno
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from facezip import FaceZipError, compress
from facezip.character.loading import load_character, save_character
from facezip.character.scans import Stack
from facezip.errors import ErrorCode
from facezip.files.images import write_texture, write_values
from facezip.files.values import read_values
from facezip.fit.choice import choose
from facezip.machine import memory
from facezip.pack.errors import pack_errors
from facezip.pack.write import write_pack
from tests.facezip.conftest import one_albedo, part_of, peak_of_compress, random_character
from tests.facezip.surfaces import random_surface
from tests.peaks import peak_of


def packed(scans, pack, **settings):
    """What is written and measured of a folder of scans: the bytes of every file, and the errors."""
    character = load_character(scans)
    write_pack(compress(character, **settings), pack)
    return {file.name: file.read_bytes() for file in pack.iterdir()}, pack_errors(character, pack)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("method", ["refined", "pca", "masks"])
def test_a_streamed_pack_has_the_bytes_of_one_made_in_memory(method, dtype, tmp_path, monkeypatch):
    save_character(random_character(side=100, expressions=6, dtype=dtype), tmp_path / "scans")
    here = packed(tmp_path / "scans", tmp_path / "here", method=method)
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed = packed(tmp_path / "scans", tmp_path / "streamed", method=method)
    assert streamed == here


def test_a_streamed_choice_by_a_streamed_importance_is_the_one_made_in_memory(tmp_path, monkeypatch):
    character = random_character(side=64, expressions=3)
    write_values(tmp_path / "importance.exr", np.random.default_rng(0).random((64, 64), np.float32))

    def chosen():
        choice = choose(character, target_rmse=4, importance=read_values(tmp_path / "importance.exr"))
        return choice.tried, choice.model

    tried, model = chosen()
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed_tried, streamed = chosen()
    assert streamed_tried == tried
    np.testing.assert_array_equal(part_of(streamed).differences, part_of(model).differences)


def test_a_streamed_glb_is_the_one_read_into_memory(tmp_path, monkeypatch):
    save_character(random_character(side=100), tmp_path / "scans.glb")
    here = load_character(tmp_path / "scans.glb")
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed = load_character(tmp_path / "scans.glb")
    np.testing.assert_array_equal(streamed.first.textures, here.first.textures)
    np.testing.assert_array_equal(streamed.first.neutral, here.first.neutral)


def test_a_limit_is_kept_where_a_run_without_it_takes_more(tmp_path):
    small = random_character(expressions=8).first
    neutral, textures = np.tile(small.neutral, (40, 40, 1)), np.tile(small.textures, (1, 40, 40, 1))
    save_character(one_albedo(Stack(neutral, textures)), tmp_path / "scans")

    in_memory, whole = peak_of_compress(tmp_path / "scans", tmp_path / "pack")
    streamed, same = peak_of_compress(tmp_path / "scans", tmp_path / "pack", "--memory", "420M")
    assert streamed < 420e6 < in_memory
    assert same["rmse"] == whole["rmse"]


# What a limit saves shows in textures of some size: a fit of them takes its time, in a process of its own.
@pytest.mark.parametrize("given", [False, True], ids=["the paper's masks", "given masks"])
def test_fits_of_masks_keep_a_limit_where_a_run_without_it_takes_more(tmp_path, given):
    small = random_character(expressions=8).first
    neutral, textures = np.tile(small.neutral, (48, 48, 1)), np.tile(small.textures, (1, 48, 48, 1))
    save_character(one_albedo(Stack(neutral, textures)), tmp_path / "scans")
    (tmp_path / "masks").mkdir()
    ramp = np.broadcast_to(np.arange(1536, dtype=np.float32) / 1536, (1536, 1536))
    write_texture(tmp_path / "masks" / "regions.png", np.rint(255 * np.stack([ramp, 1 - ramp], 2)).astype(np.uint8))
    (tmp_path / "masks" / "masks.toml").write_text('[channels]\nregions = ["left", "right"]\n')
    masks = ("--given-masks", tmp_path / "masks") if given else ("--method", "masks", "--masks", 12)
    line = ("compress", tmp_path / "scans", "-o", tmp_path / "pack", "--overwrite", "--differences", 5, *masks)
    in_memory, whole = peak_of(*line)
    streamed, same = peak_of(*line, "--memory", "480M")
    assert streamed < 480e6 < in_memory
    assert same["rmse"] == whole["rmse"]


def test_pages_that_are_let_go_keep_what_was_written(tmp_path):
    with memory.limited(1, tmp_path):
        values = memory.zeros((300, 1000), np.int64)
        assert not values.any()
        values[:] = np.arange(300)[:, None]
        memory.ease()
    np.testing.assert_array_equal(values, np.arange(300)[:, None] * np.ones(1000, int))


def test_a_file_serves_again_and_zeros_are_zeros(tmp_path):
    with memory.limited(1, tmp_path):
        first = memory.empty((30, 1000), np.int32)
        first[:] = 7
        part = first[5:, ::2]
        second = memory.zeros((30, 1000), np.int32)
        del first
        assert (part == 7).all()
        assert not second.any()
        del part
        third = memory.zeros((1000, 30), np.float32)
        assert not third.any()
        assert not np.shares_memory(second, third)
        assert len(list(memory._limit.mappings)) == 2


def test_threads_never_share_a_file(tmp_path):
    def fill(value):
        array = memory.empty((100, 100), np.int32)
        array[:] = value
        return (array == value).all()

    with memory.limited(1, tmp_path), ThreadPoolExecutor(8) as pool:
        assert all(pool.map(fill, range(2000)))


def test_nothing_is_left_of_a_killed_run(tmp_path):
    child = os.fork()
    if child == 0:
        with memory.limited(1, tmp_path):
            memory.empty((1000, 1000), np.float32)[:] = 1
            os.kill(os.getpid(), signal.SIGKILL)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("scans", ["scans", "scans.glb", "layered"])
def test_a_limit_that_is_too_small_names_the_least_that_works(scans, tmp_path):
    if scans == "layered":
        save_character(random_surface(expressions=2), tmp_path / scans)
    else:
        save_character(random_character(), tmp_path / scans)
    with memory.limited(10**6, tmp_path), pytest.raises(FaceZipError, match=r"need \d+M at least") as refusal:
        load_character(tmp_path / scans)
    assert refusal.value.code is ErrorCode.BAD_VALUE


def test_a_full_disk_is_one_line_that_says_how_much_was_asked_for(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with memory.limited(1, tmp_path), pytest.raises(FaceZipError, match=r"no room for 0\.8 GB") as refusal:
        memory.empty((10**8,), np.float64)
    assert refusal.value.code is ErrorCode.CANNOT_WRITE


@pytest.mark.parametrize("wrong", [["--method", "paper"], ["--memory", "5 apples"]])
def test_what_does_not_keep_to_a_limit_is_wrong_usage(wrong, tmp_path):
    command = [sys.executable, "-c", "from facezip.cli import main; main()", "compress", tmp_path, "-o", tmp_path / "p"]
    done = subprocess.run(
        [*map(str, [*command, "--memory", "1G", *wrong])], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "memory" in done.stderr
