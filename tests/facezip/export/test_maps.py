"""Block-compressed exports: other people's decoders read them, nothing outside the chart counts, the fit pays."""

import base64
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest
import texture2ddecoder

from facezip.blocks.codecs import bc7, raw
from facezip.errors import FaceZipError
from facezip.export import TARGETS
from facezip.export.levels import averaged_levels, fitted_levels
from facezip.export.maps import DDS, KTX2, PNG, write_maps
from facezip.export.measured import codec_errors, mip_errors
from facezip.export.mips import Pyramid, level_sizes, targets
from facezip.export.sheets import Fill
from facezip.export.source import read_source
from facezip.files.images import read_texture_exactly
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.pack.model import blend_differences
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model
from tests.facezip.export.conftest import smooth_model


def only_tile(pack):
    (tile,) = read_source(pack).tiles
    return tile


@pytest.fixture(scope="module")
def sheet(pack):
    """The sheet of an albedo."""
    (sheet,) = only_tile(pack).sheets
    return sheet


@pytest.fixture(scope="module")
def coded(sheet):
    return code(sheet)


def code(sheet):
    pyramid = Pyramid(sheet.covered)
    plain = list(averaged_levels(sheet, pyramid, raw(3)))
    fitted = list(fitted_levels(sheet, pyramid, plain, targets(sheet, pyramid), bc7()))
    return pyramid, plain, fitted


def bytes_of(levels, name="neutral"):
    return [level.stored[name] for level in levels]


@pytest.mark.parametrize("name", ["neutral", "difference_2"])
def test_openimageio_decodes_the_dds_files_to_what_was_measured(sheet, coded, tmp_path, name):
    fitted = coded[2]
    (tmp_path / "map.dds").write_bytes(DDS.container(sheet.size, bytes_of(fitted, name), name))
    for number, level in enumerate(fitted):
        image = oiio.ImageBuf(str(tmp_path / "map.dds"), 0, number)
        texels = image.get_pixels(oiio.UINT8)[..., :3]
        expected = bc7().load(level.stored[name], texels.shape)
        np.testing.assert_array_equal(texels, expected)
    assert image.nsubimages == 1
    assert oiio.ImageBuf(str(tmp_path / "map.dds"), 0, 0).nmiplevels == len(fitted)


def test_ktx_parse_reads_the_ktx2_files(sheet, coded, tmp_path, node):
    fitted = coded[2]
    (tmp_path / "map.ktx2").write_bytes(KTX2.container(sheet.size, bytes_of(fitted), "neutral"))
    [facts] = node("ktx2.mjs", tmp_path / "map.ktx2")
    assert facts["size"] == [*sheet.size, 0, 0, 1]
    assert (facts["format"], facts["scheme"], facts["model"], facts["transfer"]) == (145, 0, 134, 1)
    assert facts["keys"] == ["KTXorientation", "KTXwriter"]
    levels = [base64.b64decode(level) for level in facts["levels"]]
    assert levels == bytes_of(fitted)
    decoded = np.frombuffer(texture2ddecoder.decode_bc7(levels[0], 64, 64), np.uint8).reshape(64, 64, 4)[..., 2::-1]
    np.testing.assert_array_equal(decoded, np.rint(fitted[0].neutral * 255))


def test_levels_halve_until_one_texel_is_left():
    assert level_sizes((64, 20)) == [(64, 20), (32, 10), (16, 5), (8, 2), (4, 1), (2, 1), (1, 1)]


@pytest.mark.parametrize("size", [(32, 32), (33, 21)])
def test_no_texel_outside_the_chart_influences_any_level(size):
    rng = np.random.default_rng(0)
    covered = np.zeros(size, bool)
    covered[5:20, 3:17] = True
    inside, other = rng.random((2, *size, 3)).astype(np.float32)
    other[covered] = inside[covered]
    pyramid = Pyramid(covered)
    for levels in (pyramid.levels, pyramid.light):
        for a, b in zip(levels(inside), levels(other), strict=True):
            np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(Fill(covered)(inside), Fill(covered)(other))


def test_filling_keeps_what_is_inside_and_adds_no_new_colour():
    rng = np.random.default_rng(0)
    covered = rng.random((24, 24)) < 0.3
    texels = rng.integers(0, 256, (24, 24, 3), dtype=np.uint8)
    filled = Fill(covered)(texels)
    np.testing.assert_array_equal(filled[covered], texels[covered])
    assert {*map(tuple, filled.reshape(-1, 3))} <= {*map(tuple, texels[covered])}


def test_means_are_those_of_light_and_keep_the_whole():
    rng = np.random.default_rng(0)
    texture = rng.random((32, 24, 3)).astype(np.float32)
    levels = list(Pyramid(np.ones((32, 24), bool)).light(texture))
    np.testing.assert_array_equal(levels[0], texture)
    quarter = decode_srgb(texture).reshape(16, 2, 12, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(levels[1], encode_srgb(quarter), atol=1e-6)
    np.testing.assert_allclose(decode_srgb(levels[-1])[0, 0], decode_srgb(texture).mean(axis=(0, 1)), rtol=1e-4)


def test_the_background_of_a_pack_is_replaced_before_anything_is_coded(tmp_path):
    """Whatever is painted outside the chart, an export is the same."""
    model = smooth_model(side=32, weights=4)
    model.meshes.topology.uv[:] = 0.2 + 0.5 * model.meshes.topology.uv
    other = replace(model, neutral=model.neutral.copy())
    write_pack(model, tmp_path / "a.facezip")
    covered = only_tile(tmp_path / "a.facezip").sheets[0].covered
    assert 0.2 < covered.mean() < 0.3
    other.neutral[~covered] = 1 - other.neutral[~covered]
    write_pack(other, tmp_path / "b.facezip")
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_maps(only_tile(tmp_path / f"{name}.facezip"), tmp_path / name, DDS)
        write_maps(only_tile(tmp_path / f"{name}.facezip"), tmp_path / name, PNG)
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes(), file.name


def test_maps_fitted_to_the_codec_lose_less_than_maps_coded_one_by_one(sheet, coded):
    pyramid, plain, fitted = coded
    averaged = list(averaged_levels(sheet, pyramid, bc7()))
    together, alone = (codec_errors(sheet, pyramid, one[0])["albedo"]["rmse"] for one in (fitted, averaged))
    assert 0 < together < 0.95 * alone
    for row in mip_errors(sheet, pyramid, plain, averaged=averaged, fitted=fitted)["albedo"][1:]:
        assert row["fitted"] < row["averaged"]
        assert row["product_gap"] > 0


def test_the_stated_error_is_that_of_the_stored_blocks(sheet, coded):
    pyramid, _, fitted = coded
    stated = codec_errors(sheet, pyramid, fitted[0])["albedo"]
    name = sheet.model.expressions[1]
    scale = sheet.difference_scale
    seen = [bc7().load(fitted[0].stored[f"difference_{i}"], (64, 64, 3)) for i in range(4)]
    values = np.stack([(texels.astype(np.float32) - 128) / 255 * scale[i] for i, texels in enumerate(seen)])
    neutral = bc7().load(fitted[0].stored["neutral"], (64, 64, 3)).astype(np.float32) / 255
    gap = blend_differences(neutral, values, sheet.model.weights[1]) - sheet.model.reconstruct(name)
    assert stated["rmse_per_expression"][name] == pytest.approx(255 * np.sqrt(np.square(gap).mean()), rel=1e-4)


def test_without_a_codec_the_finest_level_is_the_pack(sheet, coded):
    pyramid, plain, _ = coded
    exact = next(fitted_levels(sheet, pyramid, plain, targets(sheet, pyramid), raw(3)))
    for name in sheet.model.expressions:
        gap = blend_differences(exact.neutral, exact.differences, sheet.model.weights[0])
        gap = gap - sheet.model.reconstruct(sheet.model.expressions[0])
        assert np.abs(gap).max() < 1e-5, name


def test_rows_lie_upside_down_where_an_engine_keeps_them_so(sheet, coded):
    pyramid, plain, fitted = coded
    stacks = targets(sheet, pyramid)
    turned = next(fitted_levels(sheet, pyramid, plain, stacks, bc7(), upside_down=True))
    decoded = bc7().load(turned.stored["neutral"], (64, 64, 3))[::-1]
    np.testing.assert_array_equal(decoded, np.rint(turned.neutral * 255))
    assert np.abs(turned.neutral - fitted[0].neutral).mean() < 0.02


def test_png_exports_hold_the_bytes_of_the_pack(pack, tmp_path):
    write_maps(only_tile(pack), tmp_path, PNG)
    for name in ("neutral", "difference_0", "difference_3"):
        written = read_texture_exactly(tmp_path / f"{name}.png")
        np.testing.assert_array_equal(written, read_texture_exactly(pack / f"{name}.png"))
    assert (tmp_path / "weights_0.png").read_bytes() == (pack / "weights.png").read_bytes()


def test_a_neutral_of_16_bits_stays_one_in_png(tmp_path):
    model = smooth_model(side=16, weights=2)
    write_pack(model, tmp_path / "wide.facezip", neutral_bits=16)
    tile = only_tile(tmp_path / "wide.facezip")
    write_maps(tile, tmp_path, PNG)
    written = read_texture_exactly(tmp_path / "neutral.png")
    assert written.dtype == np.uint16
    np.testing.assert_array_equal(written, np.rint(tile.sheets[0].model.neutral * 65535))
    write_maps(tile, tmp_path, DDS)


def test_textures_of_broken_blocks_are_refused(tmp_path):
    write_pack(random_model(size=(24, 42), meshes=True), tmp_path / "me.facezip")
    with pytest.raises(FaceZipError, match="42x24.*use --textures png"):
        TARGETS["godot"](tmp_path / "me.facezip", tmp_path / "out", textures="dds")
    assert [entry.name for entry in tmp_path.iterdir()] == ["me.facezip"]


def test_unity_s_blocks_lie_behind_a_dds_header_of_148_bytes(pack, tmp_path):
    """As the importer that comes along reads them."""
    TARGETS["unity"](pack, tmp_path / "out", textures="dds")
    content = (tmp_path / "out" / "neutral.bc7").read_bytes()
    height, width, levels = (int.from_bytes(content[at : at + 4], "little") for at in (12, 16, 28))
    assert (height, width, levels) == (64, 64, 7)
    assert "Header = 148" in (tmp_path / "out" / "Editor" / "FaceZipBlocks.cs").read_text()
    assert len(content) - 148 == sum(bc7().bytes_of(*size) for size in level_sizes((64, 64)))
    neutral = read_pack(pack).neutral
    seen = bc7().load(content[148:][: bc7().bytes_of(64, 64)], (64, 64, 3))[::-1] / 255
    assert np.sqrt(np.square(seen - neutral).mean()) < 0.02
