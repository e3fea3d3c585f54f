"""Every code has an input that is refused with it, in one line that a terminal can show."""

import os
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from facezip import ErrorCode, FaceZipError, choose, compress
from facezip.batch.processes import ProcessWorkers
from facezip.batch.workers import crew
from facezip.character.loading import load_character, save_character
from facezip.export.opengl import opened
from facezip.files.images import read_texture, write_texture
from facezip.files.obj import MAX_BYTES, read_obj, write_obj
from facezip.fit.extending import extend_into
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack
from render.llvm import usable_library
from render.presence import check_present
from tests.facezip.conftest import grid_topology, random_character, random_model
from tests.trust.claims import sign

SCANS = random_character(side=16, grid=3, expressions=2)


def scans_with(place, name, content):
    save_character(SCANS, place / "scans")
    (place / "scans" / name).write_bytes(content)
    return load_character(place / "scans")


def other_neutral(place):
    write_pack(compress(random_character(seed=1, side=16, grid=3, expressions=2)), place / "a.facezip")
    save_character(SCANS, place / "scans")
    extend_into(place / "a.facezip", place / "scans", place / "b.facezip")


def texture_of_nan(place):
    image = oiio.ImageBuf(oiio.ImageSpec(4, 4, 3, "float"))
    oiio.ImageBufAlgo.fill(image, (float("nan"),) * 3)
    image.write(str(place / "a.exr"))
    read_texture(place / "a.exr")


def mesh_beyond_the_limit(place):
    with open(place / "a.obj", "wb") as file:
        file.truncate(MAX_BYTES + 1)
    read_obj(place / "a.obj")


def other_size(place):
    save_character(SCANS, place / "scans")
    write_texture(place / "scans" / "expr_1.png", np.arange(384, dtype=np.uint16).reshape(8, 16, 3))
    load_character(place / "scans")


def other_topology(place):
    save_character(SCANS, place / "scans")
    write_obj(place / "scans" / "expr_1.obj", np.zeros((16, 3), np.float32), grid_topology(4))
    load_character(place / "scans")


def no_such_device():
    with opened(index=1000):
        pass


def damaged(place):
    write_pack(random_model(), place / "a.facezip")
    os.truncate(place / "a.facezip" / "albedo.1001.neutral.png", 100)
    verify_pack(place / "a.facezip")


def signed(place, changes):
    write_pack(random_model(), place / "a.facezip")
    sign(place / "a.facezip", changes)
    read_pack(place / "a.facezip")


def no_llvm(place):
    usable_library(str(place / "libLLVM.so"))


def nobody_at_the_address():
    with crew(None, "nonsense://nowhere", 1):
        pass


def process_that_ends_itself():
    with ProcessWorkers(1) as pool:
        pool.submit(os._exit, 1).result()


def written_twice(place):
    for _ in range(2):
        write_pack(random_model(), place / "a.facezip")


def scans_without(place, name):
    save_character(SCANS, place / "scans")
    for suffix in (".obj", ".png"):
        (place / "scans" / f"{name}{suffix}").unlink()
    load_character(place / "scans")


def head_behind_the_camera():
    check_present(np.ones((4, 4, 3), np.float32), np.full((4, 4), -1, np.int32), np.ones(2, bool), "ada, front")


CASES = {
    ErrorCode.MISSING_FILE: lambda place: load_character(place / "nobody"),
    ErrorCode.CANNOT_READ: lambda place: read_obj(place / ("a" * 300)),
    ErrorCode.TOO_LARGE: mesh_beyond_the_limit,
    ErrorCode.UNSAFE_NAME: lambda place: save_character(replace(SCANS, expressions=("../a", "b")), place / "scans"),
    ErrorCode.UNREADABLE_IMAGE: lambda place: scans_with(place, "expr_0.png", b"GIF89a"),
    ErrorCode.UNREADABLE_MESH: lambda place: scans_with(place, "expr_0.obj", b"v 0 0 0\n"),
    ErrorCode.BAD_TEXELS: texture_of_nan,
    ErrorCode.SIZE_MISMATCH: other_size,
    ErrorCode.TOPOLOGY_MISMATCH: other_topology,
    ErrorCode.OTHER_NEUTRAL: other_neutral,
    ErrorCode.TOO_FEW_EXPRESSIONS: lambda place: scans_without(place, "expr_1"),
    ErrorCode.TOO_MANY_MASKS: lambda place: compress(SCANS, "paper", masks=1000),
    ErrorCode.BAD_CHARACTER: lambda place: scans_with(place, "expr_0.tif", b""),
    ErrorCode.BAD_PACK: lambda place: signed(place, {"channels": 5}),
    ErrorCode.DAMAGED_PACK: damaged,
    ErrorCode.OTHER_FORMAT: lambda place: signed(place, {"format": "facezip-pack/4"}),
    ErrorCode.UNKNOWN_NAME: lambda place: random_model().blend({"nobody": 1.0}),
    ErrorCode.BAD_VALUE: lambda place: random_model().blend({"expr_0": float("inf")}),
    ErrorCode.OUT_OF_REACH: lambda place: choose(SCANS, budget_bytes=1),
    ErrorCode.NO_LLVM: no_llvm,
    ErrorCode.NO_GPU: lambda _: no_such_device(),
    ErrorCode.NO_SCHEDULER: lambda _: nobody_at_the_address(),
    ErrorCode.WORKER_LOST: lambda _: process_that_ends_itself(),
    ErrorCode.CANNOT_WRITE: written_twice,
    ErrorCode.NOTHING_TO_SEE: lambda _: head_behind_the_camera(),
}


@pytest.mark.parametrize("code", ErrorCode)
def test_each_code_has_an_input_that_is_refused_with_it(code, tmp_path):
    with pytest.raises(FaceZipError) as caught:
        CASES[code](tmp_path)
    assert caught.value.code is code
    assert str(caught.value).isprintable()
