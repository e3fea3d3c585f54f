"""Packs of several maps and tiles: what lies side by side is what the pack holds, and is told apart again."""

import json
from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.blocks.codecs import bc7
from facezip.character.maps import MAX_SLOPE, Map, angles, normals_of
from facezip.character.tiles import charts
from facezip.export import TARGETS
from facezip.export.fill import Fill
from facezip.export.levels import averaged_levels
from facezip.export.measured import codec_errors, mip_errors
from facezip.export.mips import Pyramid
from facezip.export.source import read_source
from facezip.files.glb import Glb
from facezip.files.images import read_texture_exactly
from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.sampling import bilinear_taps
from facezip.pack.write import write_pack
from tests.facezip.conftest import grid_topology
from tests.facezip.export.conftest import KINDS, layered_model, smooth_model
from tests.facezip.export.reading import as_exported, texels_of
from tests.facezip.export.test_textures import code
from tests.facezip.surfaces import random_surface

THREE = (KINDS[0], KINDS[2], KINDS[3])


def written(model, folder):
    write_pack(model, folder / "me.facezip")
    return folder / "me.facezip"


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    return written(layered_model(tiles=(1001, 1002), size=(32, 64)), tmp_path_factory.mktemp("packs"))


@pytest.fixture(scope="module")
def exported(pack):
    TARGETS["gltf"](pack, pack.parent / "gltf")
    return pack.parent / "gltf"


@pytest.fixture(scope="module")
def smooth(tmp_path_factory):
    """Albedo, normals and roughness of a sheet that change in the same places, as those of faces do."""
    return written(compress(random_surface(), weight_scale=16), tmp_path_factory.mktemp("packs"))


def straightforward(folder, blend, kind, read):
    """The blend of a map by the numbers of ``facezip.json``, texel by texel, as an engine programmer would do it."""
    facts = json.loads((folder / "facezip.json").read_text())
    textures, place = facts["textures"], facts["maps"][kind.name]
    weights = 0
    for name, weight in blend.items():
        column, row = facts["expressions"][name]["weight_tile"]
        layers = []
        for layer in range(facts["layers"]):
            entry = textures[f"weights_{layer}"]
            h, w = entry["size"]
            atlas = read_texture_exactly(folder / entry["file"])
            texels = atlas[row * h : (row + 1) * h, column * w : (column + 1) * w]
            layers.append((texels / 255)[..., : len(entry["scale"])] * entry["scale"] + entry["offset"])
        weights = weights + weight * np.concatenate(layers, axis=2)
    height, width = place["size"]
    (top, bottom, down), (left, right, across) = bilinear_taps(height, h), bilinear_taps(width, w)
    rows = weights[top] + down[:, None, None] * (weights[bottom] - weights[top])
    weights = rows[:, left] + across[:, None] * (rows[:, right] - rows[:, left])
    channels = place["channels"]
    low, high = place["range"]
    value = low + (high - low) * read(textures[place["neutral"]])[..., channels]
    if place["encoding"] == "normal":
        value = value / np.sqrt(1 - np.square(value).sum(axis=2, keepdims=True))
        low, high = -MAX_SLOPE, MAX_SLOPE
    for slot, name in enumerate(place["differences"]):
        entry = textures[name]
        difference = (read(entry)[..., channels] - entry["zero"]) * np.array(entry["scale"])[channels]
        value = value + weights[..., slot : slot + 1] * difference
    value = np.clip(value, low, high)
    return normals_of(value) if kind.is_normal else value


def reader(folder):
    return lambda entry: texels_of(folder / entry["file"])


def test_every_map_of_every_tile_is_there_by_the_document_alone(pack, exported):
    model, blend = read_pack(pack), {"expr_0": 0.7, "expr_2": 0.4}
    for tile in model.tiles:
        folder = exported / str(tile)
        for kind in model.maps:
            seen = straightforward(folder, blend, kind, reader(folder))
            np.testing.assert_allclose(
                seen, model.blend(blend, kind.name, tile), atol=2e-5 * kind.unit, err_msg=kind.name
            )


def test_maps_share_textures_where_they_fit(pack, exported):
    """Of five maps of 3 + 1 + 2 + 1 + 1 channels there are three sheets; weights are there once."""
    images = sorted(file.name for file in (exported / "1002").glob("*.png"))
    sheets = ("", "cavity_normal_", "roughness_specular_")
    names = [f"{sheet}{name}.png" for sheet in sheets for name in ("neutral", *(f"difference_{i}" for i in range(4)))]
    assert images == sorted([*names, "weights_0.png"])
    weights = (exported / "1002" / "weights_0.png").read_bytes()
    assert weights == (pack / "weights.1002.png").read_bytes()
    for name, kind, channels in (("cavity_normal", "normal", [1, 2]), ("cavity_normal", "cavity", [0])):
        stored = "difference_1"
        ours = read_texture_exactly(exported / "1002" / f"{name}_{stored}.png")[..., channels]
        theirs = read_texture_exactly(pack / f"{kind}.1002.{stored}.png")[..., : len(channels)]
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("change", ["size", "bits"])
def test_maps_that_differ_do_not_share(tmp_path, change):
    model = layered_model(kinds=THREE, size=(24, 40))
    if change == "size":
        other = layered_model(kinds=THREE, size=(48, 80)).parts["roughness", 1001]
    else:
        other = replace(model.parts["roughness", 1001], bits=16)
    write_pack(replace(model, parts={**model.parts, ("roughness", 1001): other}), tmp_path / "me.facezip")
    (tile,) = read_source(tmp_path / "me.facezip").tiles
    assert [sheet.name for sheet in tile.sheets] == ["", "normal", "roughness"]
    TARGETS["godot"](tmp_path / "me.facezip", tmp_path / "out")
    stored = read_texture_exactly(tmp_path / "out" / "roughness_neutral.png")
    assert (stored.shape, stored.dtype) == (((48, 80, 1), "u1") if change == "size" else ((24, 40, 1), "u2"))


def test_blocks_keep_normals_alone_where_that_takes_no_fetch_more(tmp_path):
    """Of five maps: cavity, roughness and specular fill a sheet. Of three, normals and roughness have to share."""
    for kinds, sheets in ((KINDS, ["", "cavity_roughness_specular_", "normal_"]), (THREE, ["", "normal_roughness_"])):
        folder = tmp_path / str(len(kinds))
        folder.mkdir()
        pack = written(layered_model(smooth_model, kinds=kinds, side=16, weights=2), folder)
        document = TARGETS["godot"](pack, folder / "out", textures="dds")
        files = {file.name for file in (folder / "out").glob("*.dds")}
        names = ("neutral", *(f"difference_{i}" for i in range(4)))
        assert files == {f"{sheet}{name}.dds" for sheet in sheets for name in names}
        assert document.maps["normal"].codec.name == ("bc5" if kinds is KINDS else "bc7")
        plain = TARGETS["godot"](pack, folder / "png")
        assert len(plain.textures) == len(document.textures)


def test_apart_every_map_has_textures_of_its_own(pack, tmp_path):
    document = TARGETS["godot"](pack, tmp_path / "out", maps="apart").tiles["1002"]
    folder, model, blend = tmp_path / "out" / "1002", read_pack(pack), {"expr_0": 0.7, "expr_2": 0.4}
    textures = [{place.neutral, *place.differences} for place in document.maps.values()]
    assert len(set.union(*textures)) == sum(map(len, textures)) == 5 * len(KINDS)
    for kind in model.maps:
        seen = straightforward(folder, blend, kind, reader(folder))
        np.testing.assert_allclose(seen, model.blend(blend, kind.name, 1002), atol=2e-5 * kind.unit)


def test_what_is_stored_is_read_back(pack):
    model = read_pack(pack)
    for tile in read_source(pack).tiles:
        for sheet in tile.sheets:
            neutral, *differences = sheet.images()
            assert neutral.shape[2] == 3
            for kind, at in sheet.maps:
                part = model.parts[kind.name, tile.layout.number]
                np.testing.assert_allclose(sheet.unpacked(neutral)[..., at], part.neutral, atol=1e-6)
                for slot, steps in enumerate(differences):
                    seen = sheet.difference(steps, slot)[..., at]
                    np.testing.assert_allclose(seen, part.differences[slot], atol=1e-6)


def test_a_part_is_that_of_the_pack(pack):
    model = read_pack(pack)
    for tile in read_source(pack).tiles:
        for sheet in tile.sheets:
            whole = sheet.dequantised()
            for kind, at in sheet.maps:
                part = model.parts[kind.name, tile.layout.number]
                np.testing.assert_array_equal(whole.neutral[..., at], part.neutral)
                np.testing.assert_array_equal(whole.differences[..., at], part.differences)


@pytest.mark.parametrize("maps", ["together", "apart"])
def test_others_see_blends_as_far_from_the_pack_as_is_stated(smooth, maps, tmp_path):
    document = TARGETS["godot"](smooth, tmp_path / "out", textures="dds", maps=maps)
    model, name = read_pack(smooth), "expr_1"
    for kind in model.maps:
        seen = straightforward(tmp_path / "out", {name: 1.0}, kind, reader(tmp_path / "out"))
        np.testing.assert_allclose(as_exported(model, tmp_path / "out").reconstruct(name, kind.name), seen, atol=1e-5)
        wanted = model.blend({name: 1.0}, kind.name)
        codec = document.maps[kind.name].codec
        if kind.is_normal:
            error, stated = angles(seen.astype(np.float32), wanted).mean(), codec.angular_error_per_expression[name]
        else:
            error, stated = 255 * np.sqrt(np.square(seen - wanted).mean()), codec.rmse_per_expression[name]
        assert error == pytest.approx(stated, rel=1e-3)
        assert error < 4


def test_slopes_are_averaged_as_slopes(smooth):
    """A surface half of which rises and half of which falls is flat from afar, however steep; unit vectors say less."""
    (tile,) = read_source(smooth).tiles
    sheet, at = tile.sheet_of("normal")
    kind = THREE[1]
    slopes = np.zeros((64, 64, 2), np.float32)
    slopes[:, ::2] = (3.0, 0.0)
    slopes[:, 1::2] = (-1.0, 0.5)
    values = np.full((64, 64, 3), 0.25, np.float32)
    values[..., at] = kind.encode(normals_of(slopes))
    looks = list(Pyramid(Fill(np.ones((64, 64), bool))).looks(sheet, values))
    for look in looks[1:]:
        expected = normals_of(np.broadcast_to(np.float32([1.0, 0.25]), (*look.shape[:2], 2)))
        assert angles(kind.decode(look[..., at]), expected).max() < 0.01
        np.testing.assert_allclose(look[..., 2], 0.25, atol=1e-6)
    vectors = normals_of(slopes)[:2, :2].mean(axis=(0, 1))
    assert angles(vectors / np.linalg.norm(vectors), kind.decode(looks[1][..., at])[0, 0]) > 10


def test_levels_that_are_fitted_are_nearer_for_every_map(smooth):
    (tile,) = read_source(smooth).tiles
    sheet = tile.sheets[1]
    assert sheet.name == "normal_roughness"
    part, pyramid, plain, fitted = code(sheet)
    averaged = list(averaged_levels(sheet, part, pyramid, bc7()))
    rows = mip_errors(sheet, part, pyramid, plain, fitted=fitted, averaged=averaged)
    assert [len(of_map) for of_map in rows.values()] == [4, 4]
    # Channels of one block pay for each other; together they gain at every level.
    gains = [[row.fitted / row.averaged for row in levels] for levels in zip(*rows.values(), strict=True)]
    assert max(np.mean(gains, axis=1)) < 1, gains
    assert np.mean(gains) < 0.9, gains
    exact = codec_errors(sheet, part, pyramid, plain[0].part)
    assert exact["normal"].mean < 1e-3
    assert exact["roughness"].mean < 1e-3


def test_the_glb_has_a_material_for_each_tile(pack, exported, node):
    issues = node("validate.mjs", exported / "head.glb")
    # No tangents: engines make them, and the validator says that they have to.
    assert {message["code"] for message in issues["messages"]} <= {"MESH_PRIMITIVE_GENERATED_TANGENT_SPACE"}
    glb = Glb.parse((exported / "head.glb").read_bytes())
    (mesh,) = glb.document["meshes"]
    assert [one["material"] for one in mesh["primitives"]] == [0, 1]
    assert mesh["extras"]["targetNames"] == list(read_pack(pack).expressions)
    faces = sum(len(glb.array(one["indices"])) // 3 for one in mesh["primitives"])
    assert faces == len(read_pack(pack).meshes.topology.faces)
    for number, (one, material) in enumerate(zip(mesh["primitives"], glb.document["materials"], strict=True)):
        uv = glb.array(one["attributes"]["TEXCOORD_0"])
        # A triangle of the sheet lies across the border.
        assert ((uv[:, 0] > -0.4) & (uv[:, 0] < 1.4)).all()
        assert abs(uv[:, 0].mean() - 0.5) < 0.2
        assert material["extras"] == {"tile": 1001 + number}
        assert {"normalTexture", "pbrMetallicRoughness"} <= material.keys()


def test_three_js_shows_a_glb_of_several_maps(smooth, tmp_path, node):
    TARGETS["gltf"](smooth, tmp_path / "out")
    seen = node("three.mjs", tmp_path / "out" / "head.glb")
    assert seen["textured"]
    assert seen["names"] == list(read_pack(smooth).expressions)


def test_every_face_goes_to_its_tile_or_the_nearest():
    topology = grid_topology(10)
    topology.uv[:] = topology.uv * (3, 2)
    tiles = [1001, 1002, 1012]
    parts = charts(topology, tiles)
    assert sum(len(part.faces) for part in parts) == len(topology.faces)
    middles = topology.uv[topology.face_uv].mean(axis=1)
    for tile, part in zip(tiles, parts, strict=True):
        column, row = (tile - 1001) % 10, (tile - 1001) // 10
        own = ((np.floor(middles) == (column, row)).all(axis=1)).sum()
        inside = np.floor(part.uv[part.face_uv].mean(axis=1)) == 0
        assert inside.all(axis=1).sum() == own > 0


@pytest.mark.parametrize(
    ("kinds", "message"),
    [
        ((KINDS[2],), "no albedo"),
        ((KINDS[0], Map("weights_of_hair", "data")), "weights_of_hair"),
        ((KINDS[0], Map("a__b", "data")), "a__b"),
        ((KINDS[0], Map("a", "data"), Map("a_b", "srgb"), Map("b", "data")), "a_b"),
    ],
)
def test_what_no_material_takes_is_refused_in_one_line(tmp_path, kinds, message):
    pack = written(layered_model(kinds=kinds), tmp_path)
    with pytest.raises(FaceZipError, match=message) as caught:
        TARGETS["godot"](pack, tmp_path / "out")
    assert len(str(caught.value).splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_map_that_is_not_what_its_name_says_is_for_shaders_of_ones_own(tmp_path):
    kinds = (KINDS[0], Map("normal", "data"), Map("roughness", "data", 0.0, 4.0))
    pack = written(layered_model(kinds=kinds), tmp_path)
    for target in ("godot", "unity", "unreal", "gltf"):
        TARGETS[target](pack, tmp_path / target)
    assert "NORMAL_MAP" not in (tmp_path / "godot" / "head.gdshader").read_text()
    assert "tangent" not in (tmp_path / "unity" / "FaceZipHead.shader").read_text()
    assert "MP_NORMAL" not in (tmp_path / "unreal" / "setup_facezip.py").read_text()
    assert "normalTexture" not in Glb.parse((tmp_path / "gltf" / "head.glb").read_bytes()).document["materials"][0]


def test_uastc_holds_every_map_as_plain_numbers_but_the_colour_that_is_shown(tmp_path, node, encoder):
    pack = written(layered_model(smooth_model, THREE, side=16, weights=2), tmp_path)
    TARGETS["gltf"](pack, tmp_path / "out", textures="ktx2")
    assert node("validate.mjs", tmp_path / "out" / "head.glb")["numErrors"] == 0
    names = ("neutral", "difference_0", "normal_roughness_neutral", "normal_roughness_difference_3")
    read = node("ktx2.mjs", *(tmp_path / "out" / f"{name}.ktx2" for name in names))
    assert [facts["transfer"] for facts in read] == [2, 1, 1, 1]
    assert [len(facts["levels"]) for facts in read] == [5] * 4
