import shutil

import numpy as np
import pytest

from facezip import FaceZipError, compress
from facezip.character.loading import load_character, save_character
from facezip.errors import ErrorCode
from facezip.files.images import write_texture
from facezip.files.obj import write_obj
from facezip.pack.write import write_pack
from tests.facezip.conftest import grid_topology, random_character


@pytest.fixture
def folder(tmp_path, character):
    save_character(character, tmp_path / "sheet")
    return tmp_path / "sheet"


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_character_reads_back_as_it_was_saved(tmp_path, dtype):
    character = random_character(dtype=dtype)
    save_character(character, tmp_path / "sheet")
    back = load_character(tmp_path / "sheet")
    assert (back.name, back.expressions) == (character.name, character.expressions)
    np.testing.assert_array_equal(back.meshes.vertices, character.meshes.vertices)
    np.testing.assert_allclose(back.first.textures, character.first.textures, atol=1e-6)
    assert back.first.textures.dtype == dtype


def test_a_mask_limits_the_region(folder):
    mask = np.zeros((32, 32, 1), np.uint8)
    mask[8:24] = 255
    write_texture(folder / "mask.png", mask)
    np.testing.assert_array_equal(load_character(folder).first.mask, mask[..., 0] / 255)


def spoil_texture(folder):
    (folder / "expr_1.png").unlink()


def spoil_mesh(folder):
    (folder / "expr_1.obj").unlink()


def spoil_neutral(folder):
    (folder / "neutral.obj").unlink()


def spoil_size(folder):
    write_texture(folder / "expr_1.png", np.arange(768).reshape(16, 16, 3).astype(np.uint8))


def spoil_depth(folder):
    write_texture(folder / "expr_1.png", np.zeros((32, 32, 3), np.uint16))


def spoil_channels(folder):
    write_texture(folder / "expr_1.png", np.zeros((32, 32, 1), np.uint8))


def spoil_topology(folder):
    topology = grid_topology(8)
    write_obj(folder / "expr_1.obj", np.zeros((64, 3), np.float32), topology)


def spoil_layout(folder):
    lines = (folder / "expr_1.obj").read_text().replace("vt 0 0\n", "vt 0.5 0\n", 1)
    (folder / "expr_1.obj").write_text(lines)


def spoil_mask(folder):
    write_texture(folder / "mask.png", np.zeros((32, 32, 1), np.uint8))


def spoil_twice(folder):
    write_texture(folder / "expr_1.tif", np.zeros((32, 32, 3), np.uint8))


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (spoil_texture, "expr_1.png"),
        (spoil_mesh, "expr_1.obj"),
        (spoil_neutral, "neutral.obj"),
        (spoil_size, "expr_1.png"),
        (spoil_depth, "expr_1.png"),
        (spoil_channels, "expr_1.png"),
        (spoil_topology, "expr_1.obj"),
        (spoil_layout, "expr_1.obj"),
        (spoil_mask, "mask.png"),
        (spoil_twice, "expr_1.tif"),
    ],
)
def test_a_spoilt_character_is_refused_in_one_line_that_names_the_file(folder, spoil, named):
    spoil(folder)
    with pytest.raises(FaceZipError, match=named) as caught:
        load_character(folder)
    assert "\n" not in str(caught.value)


def test_an_empty_folder_and_a_lone_expression_are_refused(tmp_path, folder):
    (tmp_path / "empty").mkdir()
    with pytest.raises(FaceZipError, match="no neutral.obj"):
        load_character(tmp_path / "empty")
    for n in range(1, 5):
        (folder / f"expr_{n}.obj").unlink()
        (folder / f"expr_{n}.png").unlink()
    with pytest.raises(FaceZipError, match="at least two"):
        load_character(folder)


def test_the_order_of_expressions_is_that_of_their_names(tmp_path, folder):
    shutil.copytree(folder, tmp_path / "copy")
    assert load_character(tmp_path / "copy").expressions == tuple(sorted(load_character(folder).expressions))


def test_a_pack_in_the_place_of_scans_is_named_as_one(character, tmp_path):
    write_pack(compress(character), tmp_path / "me.facezip")
    with pytest.raises(FaceZipError, match=r"me\.facezip: is a pack; give the folder of scans") as refusal:
        load_character(tmp_path / "me.facezip")
    assert refusal.value.code is ErrorCode.BAD_CHARACTER
