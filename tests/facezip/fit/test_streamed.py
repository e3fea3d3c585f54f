"""Surfaces under a limit of memory, and read by other bands: less is resident, and nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.character.loading import load_character, save_character
from facezip.character.maps import Map
from facezip.character.scans import Stack
from facezip.files import decoding
from facezip.fit.methods import compress
from facezip.machine import memory
from facezip.pack.errors import model_errors
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import peak_of_compress
from tests.facezip.surfaces import random_surface, write_floats


@pytest.fixture(scope="module", params=["8 bits", "16 bits", "floats"])
def scans(request, tmp_path_factory):
    """Albedo, normals and roughness on two tiles; floats beyond 0..1 where they are kept."""
    folder = tmp_path_factory.mktemp("surfaces") / "scans"
    surface = random_surface(side=100, tiles=(2, 1))
    if request.param == "8 bits":
        save_character(surface, folder)
        return folder
    floats = request.param == "floats"
    change = _as_floats if floats else _as_shorts
    stacks = {key: change(stack) for key, stack in surface.stacks.items()}
    kinds = tuple(Map(kind.name, kind.encoding, -0.5, 2.0) if kind.name == "roughness" and floats else kind
                  for kind in surface.maps)  # fmt: skip
    changed = replace(surface, maps=kinds, stacks=stacks)
    save_character(changed, folder)
    for tile in changed.tiles if floats else ():
        for expression in ("neutral", *changed.expressions):
            file = folder / f"{expression}.normal.{tile}.png"
            write_floats(file.with_suffix(".exr"), changed.texture(expression, "normal", tile))
            file.unlink()
    return folder


def _as_shorts(part):
    """Normals of 16 bits are fitted as floats."""
    if part.neutral.dtype == np.uint16:
        return _as_floats(part)
    return replace(part, neutral=part.neutral * np.uint16(257), textures=part.textures * np.uint16(257))


def _as_floats(part):
    most = np.float32(np.iinfo(part.neutral.dtype).max)
    return replace(part, neutral=part.neutral / most, textures=part.textures / most)


def loaded(scans):
    return load_character(scans, keep_floats=(scans / "neutral.1001.exr").exists())


def packed(scans, pack, method):
    """What is written and measured of a folder of scans: the bytes of every file, and the errors."""
    surface = loaded(scans)
    write_pack(compress(surface, method), pack)
    return {file.name: file.read_bytes() for file in pack.iterdir()}, model_errors(surface, read_pack(pack))


@pytest.mark.parametrize("method", ["refined", "pca", "masks"])
def test_a_streamed_pack_has_the_bytes_of_one_made_in_memory(method, scans, tmp_path, monkeypatch):
    here = packed(scans, tmp_path / "here", method)
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed = packed(scans, tmp_path / "streamed", method)
    assert streamed == here


def test_what_is_read_does_not_depend_on_the_rows_that_are_decoded_at_a_time(scans, monkeypatch):
    whole = loaded(scans)
    monkeypatch.setattr(decoding, "BAND", 7)
    banded = loaded(scans)
    assert banded.maps == whole.maps
    for key, stack in whole.stacks.items():
        np.testing.assert_array_equal(banded.stacks[key].neutral, stack.neutral)
        np.testing.assert_array_equal(banded.stacks[key].textures, stack.textures)


def test_a_limit_is_kept_where_a_run_without_it_takes_more(tmp_path):
    small = random_surface(expressions=6, tiles=(2, 1))
    stacks = {
        key: Stack(np.tile(stack.neutral, (10, 20, 1)), np.tile(stack.textures, (1, 10, 20, 1)))
        for key, stack in small.stacks.items()
    }
    save_character(replace(small, stacks=stacks), tmp_path / "scans")

    in_memory, whole = peak_of_compress(tmp_path / "scans", tmp_path / "pack")
    streamed, same = peak_of_compress(tmp_path / "scans", tmp_path / "pack", "--memory", "420M")
    assert streamed < 420e6 < in_memory
    assert same["errors"] == whole["errors"]
