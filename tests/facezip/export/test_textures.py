"""Block-compressed exports: other people's decoders read them, nothing outside the chart counts, the fit pays."""

import base64
import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from facezip.blocks.codecs import bc4, bc5, bc7, raw
from facezip.errors import FaceZipError
from facezip.export import TARGETS
from facezip.export.fill import Fill
from facezip.export.formats import DDS, PNG
from facezip.export.levels import averaged_levels, fitted_levels
from facezip.export.measured import codec_errors, mip_errors
from facezip.export.mips import Pyramid, level_sizes, targets
from facezip.export.source import read_source
from facezip.export.textures import write_maps
from facezip.files.images import read_texture_exactly
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.pack.model import blended_rows
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import ALBEDO_KEY, masked, random_model
from tests.facezip.export.conftest import KINDS, layered_model, smooth_model, with_part


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


def code(sheet, codec=None, **options):
    """What is held of a sheet, which of its texels count, its plain levels, and those fitted to a codec."""
    part, pyramid = sheet.dequantised(), Pyramid(sheet.fill)
    plain = list(averaged_levels(sheet, part, pyramid, raw(3)))
    stacks = targets(sheet, part, pyramid)
    fitted = list(fitted_levels(sheet, part, pyramid, plain, stacks, codec or bc7(), **options))
    return part, pyramid, plain, fitted


def file_of(form, sheet, codec, levels, name, folder):
    """The file of a texture."""
    file = folder / f"{name}{form.suffix}"
    file.write_bytes(b"".join(form.pieces(sheet.size, [level.stored[name] for level in levels], codec.name, name)))
    return file


def blend(part, weights):
    return blended_rows(part, weights)(slice(0, len(part.neutral)))


@pytest.mark.parametrize("name", ["neutral", "difference_2"])
def test_openimageio_decodes_the_dds_files_to_what_was_measured(sheet, coded, tmp_path, name):
    fitted = coded[3]
    file = str(file_of(DDS, sheet, bc7(), fitted, name, tmp_path))
    for number, level in enumerate(fitted):
        image = oiio.ImageBuf(file, 0, number)
        texels = image.get_pixels(oiio.UINT8)[..., :3]
        expected = bc7().load(level.stored[name], texels.shape)
        np.testing.assert_array_equal(texels, expected)
    assert image.nsubimages == 1
    assert oiio.ImageBuf(file, 0, 0).nmiplevels == len(fitted)


@pytest.fixture(scope="module")
def apart(tmp_path_factory):
    """A pack of several maps, whose export gives each textures of its own."""
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(layered_model(smooth_model, (KINDS[0], KINDS[2], KINDS[3])), path)
    return path


@pytest.mark.parametrize(("name", "codec"), [("normal", bc5()), ("roughness", bc4())], ids=["bc5", "bc4"])
def test_openimageio_decodes_channels_that_are_not_shared_to_what_was_measured(apart, tmp_path, name, codec):
    document = TARGETS["godot"](apart, tmp_path / "out", textures="dds", maps="apart")
    assert document.maps[name].codec.name == codec.name
    (tile,) = read_source(apart, "apart").tiles
    sheet, _ = tile.sheet_of(name)
    fitted = code(sheet, codec)[3]
    for texture in sheet.textures:
        file = str(tmp_path / "out" / f"{texture}.dds")
        assert oiio.ImageBuf(file, 0, 0).nmiplevels == len(fitted) == 7
        for number, level in enumerate(fitted):
            texels = oiio.ImageBuf(file, 0, number).get_pixels(oiio.UINT8)[..., : codec.channels]
            expected = codec.load(level.stored[texture], texels.shape)
            # Its decoder has 8 bits, and truncates.
            assert np.abs(texels - expected / 257).max() < 1.01


@pytest.mark.parametrize(
    ("maps", "name", "format_", "model", "samples"),
    [
        ("together", "albedo", 145, 134, [[0, 0, 127]]),
        ("apart", "normal", 141, 132, [[0, 0, 63], [1, 64, 63]]),
        ("apart", "roughness", 139, 131, [[0, 0, 63]]),
    ],
)
def test_ktx_parse_reads_the_ktx2_files(apart, tmp_path, node, maps, name, format_, model, samples):
    TARGETS["godot"](apart, tmp_path / "out", textures="ktx2", maps=maps)
    (tile,) = read_source(apart, maps).tiles
    sheet, _ = tile.sheet_of(name)
    codec = {1: bc4(), 2: bc5(), 3: bc7()}[sheet.channels]
    (facts,) = node("ktx2.mjs", tmp_path / "out" / f"{sheet.textures[0]}.ktx2")
    assert facts["size"] == [*sheet.size, 0, 0, 1]
    assert (facts["format"], facts["scheme"], facts["model"], facts["transfer"]) == (format_, 2, model, 1)
    assert facts["samples"] == samples
    assert facts["keys"] == ["KTXorientation", "KTXwriter", "KTXwriterScParams"]
    assert facts["options"] == "--zstd 19"
    levels = [base64.b64decode(level) for level in facts["levels"]]
    assert levels == [level.stored[sheet.textures[0]].tobytes() for level in code(sheet, codec)[3]]
    assert facts["frames"][0] < len(levels[0])


def test_levels_halve_until_one_texel_is_left():
    assert level_sizes((64, 20)) == [(64, 20), (32, 10), (16, 5), (8, 2), (4, 1), (2, 1), (1, 1)]


@pytest.mark.parametrize("size", [(32, 32), (33, 21)])
def test_no_texel_outside_the_chart_influences_any_level(size):
    rng = np.random.default_rng(0)
    covered = np.zeros(size, bool)
    covered[5:20, 3:17] = True
    inside, other = rng.random((2, *size, 3)).astype(np.float32)
    other[covered] = inside[covered]
    pyramid = Pyramid(Fill(covered))
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


@given(st.integers(1, 300), st.integers(1, 4))
def test_each_texel_of_a_level_is_the_mean_over_its_part_of_the_one_above(height, width):
    values = np.random.default_rng(height).random((height, width, 1), np.float32)
    levels = [level[..., 0] for level in Pyramid(Fill(np.ones((height, width), bool))).levels(values)]
    for above, below in pairwise(levels):
        expected = shrunk(shrunk(above, len(below)).T, below.shape[1]).T
        np.testing.assert_allclose(below, expected, atol=1e-5)


def shrunk(values, rows):
    """Means over equal parts of the columns, as differences of their integrals."""
    integrals = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0, dtype=np.float64)])
    edges, ends = np.linspace(0, len(values), rows + 1), np.arange(len(values) + 1)
    sums = [np.interp(edges, ends, integral) for integral in integrals.T]
    return np.diff(sums).T * rows / len(values)


def test_means_of_long_rows_take_no_memory_of_a_texture():
    """Every texel above by every texel below would be 134 MB."""
    fill = Fill(np.ones((8192, 1), bool))
    tracemalloc.start()
    Pyramid(fill)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5e6


def test_means_are_those_of_light_and_keep_the_whole():
    rng = np.random.default_rng(0)
    texture = rng.random((32, 24, 3)).astype(np.float32)
    levels = list(Pyramid(Fill(np.ones((32, 24), bool))).light(texture))
    np.testing.assert_array_equal(levels[0], texture)
    quarter = decode_srgb(texture).reshape(16, 2, 12, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(levels[1], encode_srgb(quarter), atol=1e-6)
    np.testing.assert_allclose(decode_srgb(levels[-1])[0, 0], decode_srgb(texture).mean(axis=(0, 1)), rtol=1e-4)


def test_the_nearest_texel_inside_is_scipy_s():
    rng = np.random.default_rng(0)
    for _ in range(200):
        height, width = rng.integers(1, 80, 2)
        covered = rng.random((height, width)) < rng.choice([0.001, 0.01, 0.1, 0.9])
        covered[rng.integers(height), rng.integers(width)] = True
        texels = np.stack(np.indices(covered.shape), axis=2)
        expected = distance_transform_edt(~covered, return_distances=False, return_indices=True)
        np.testing.assert_array_equal(Fill(covered)(texels), np.moveaxis(expected, 0, 2))


def test_the_background_of_a_pack_is_replaced_before_anything_is_coded(tmp_path):
    """Whatever is painted outside the chart, an export is the same."""
    model = smooth_model(side=32, weights=4)
    model.meshes.topology.uv[:] = 0.2 + 0.5 * model.meshes.topology.uv
    write_pack(model, tmp_path / "a.facezip")
    covered = only_tile(tmp_path / "a.facezip").sheets[0].fill.covered
    assert 0.2 < covered.mean() < 0.3
    part = model.parts[ALBEDO_KEY]
    painted = np.where(covered[..., None], part.neutral, 1 - part.neutral)
    write_pack(with_part(model, painted, part.differences), tmp_path / "b.facezip")
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_maps(only_tile(tmp_path / f"{name}.facezip"), tmp_path / name, DDS)
        write_maps(only_tile(tmp_path / f"{name}.facezip"), tmp_path / name, PNG)
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes(), file.name


def test_maps_fitted_to_the_codec_lose_less_than_maps_coded_one_by_one(sheet, coded):
    part, pyramid, plain, fitted = coded
    averaged = list(averaged_levels(sheet, part, pyramid, bc7()))
    together, alone = (codec_errors(sheet, part, pyramid, one[0].part)["albedo"].mean for one in (fitted, averaged))
    assert 0 < together < 0.95 * alone
    for row in mip_errors(sheet, part, pyramid, plain, averaged=averaged, fitted=fitted)["albedo"][1:]:
        assert row.fitted < row.averaged
        assert row.product_gap > 0


@pytest.mark.parametrize(("name", "codec"), [("normal", bc5()), ("roughness", bc4())], ids=["bc5", "bc4"])
def test_every_codec_s_levels_are_nearer_where_they_are_fitted(apart, name, codec):
    (tile,) = read_source(apart, "apart").tiles
    sheet, _ = tile.sheet_of(name)
    part, pyramid, plain, fitted = code(sheet, codec)
    averaged = list(averaged_levels(sheet, part, pyramid, codec))
    for row in mip_errors(sheet, part, pyramid, plain, averaged=averaged, fitted=fitted)[name]:
        assert row.fitted < 0.95 * row.averaged


def test_the_stated_error_is_that_of_the_stored_blocks(sheet, coded):
    part, pyramid, _, fitted = coded
    stated = codec_errors(sheet, part, pyramid, fitted[0].part)["albedo"]
    seen = [bc7().load(fitted[0].stored[f"difference_{i}"], (64, 64, 3)) for i in range(4)]
    values = np.stack([(texels.astype(np.float32) - 128) / 255 * sheet.span[i] for i, texels in enumerate(seen)])
    neutral = bc7().load(fitted[0].stored["neutral"], (64, 64, 3)).astype(np.float32) / 255
    shown = replace(part, neutral=neutral, differences=values)
    gap = blend(shown, sheet.weights[1]) - blend(part, sheet.weights[1])
    name = sheet.expressions[1]
    assert stated.per_expression[name] == pytest.approx(255 * np.sqrt(np.square(gap).mean()), rel=1e-4)


def test_without_a_codec_the_finest_level_is_the_pack(pack, sheet):
    exact, model = code(sheet, raw(3))[3][0].part, read_pack(pack)
    for name, weights in zip(sheet.expressions, sheet.weights, strict=True):
        assert np.abs(blend(exact, weights) - model.reconstruct(name)).max() < 1e-5, name


def test_rows_lie_upside_down_where_an_engine_keeps_them_so(sheet, coded):
    turned, fitted = (levels[0] for levels in (code(sheet, upside_down=True)[3], coded[3]))
    decoded = bc7().load(turned.stored["neutral"], (64, 64, 3))[::-1]
    np.testing.assert_array_equal(decoded, np.rint(turned.part.neutral * 255))
    assert np.abs(turned.part.neutral - fitted.part.neutral).mean() < 0.02


def test_png_exports_hold_the_bytes_of_the_pack(pack, tmp_path):
    write_maps(only_tile(pack), tmp_path, PNG)
    for name in ("neutral", "difference_0", "difference_3"):
        written = read_texture_exactly(tmp_path / f"{name}.png")
        np.testing.assert_array_equal(written, read_texture_exactly(pack / f"albedo.1001.{name}.png"))
    assert (tmp_path / "weights_0.png").read_bytes() == (pack / "weights.1001.png").read_bytes()


def test_a_neutral_of_16_bits_stays_one_in_png(tmp_path):
    model = smooth_model(side=16, weights=2)
    part = model.parts[ALBEDO_KEY]
    write_pack(with_part(model, part.neutral, part.differences, bits=16), tmp_path / "wide.facezip")
    tile = only_tile(tmp_path / "wide.facezip")
    write_maps(tile, tmp_path, PNG)
    written = read_texture_exactly(tmp_path / "neutral.png")
    assert written.dtype == np.uint16
    np.testing.assert_array_equal(written, np.rint(part.neutral * 65535))
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
    neutral = read_pack(pack).parts[ALBEDO_KEY].neutral
    seen = bc7().load(np.frombuffer(content, np.uint8)[148:][: bc7().bytes_of(64, 64)], (64, 64, 3))[::-1] / 255
    assert np.sqrt(np.square(seen - neutral).mean()) < 0.02


def test_weight_maps_that_are_made_of_masks_are_written_within_half_a_step(tmp_path):
    write_pack(masked(smooth_model(slots=5)), tmp_path / "me.facezip")
    (tile,) = read_source(tmp_path / "me.facezip", expanded=True).tiles
    document = write_maps(tile, tmp_path, PNG).textures
    model = read_pack(tmp_path / "me.facezip")
    for layer, slots in (("weights_0", slice(0, 4)), ("weights_1", slice(4, 5))):
        entry = document[layer]
        (h, w), columns, image = entry.size, entry.columns, read_texture_exactly(tmp_path / entry.file)
        for n in range(len(model.expressions)):
            y, x = h * (n // columns), w * (n % columns)
            texels = image[y : y + h, x : x + w, : slots.stop - slots.start]
            values = texels / 255 * entry.scale + entry.offset
            assert np.abs(values - model.weights[1001][n, ..., slots]).max() <= 0.501 * max(entry.scale) / 255
