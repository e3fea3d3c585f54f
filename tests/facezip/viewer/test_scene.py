import io
import re
import shutil
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from facezip import FaceZipError
from facezip.character.maps import ALBEDO, Map
from facezip.character.tiles import charts
from facezip.files.renaming import exchange
from facezip.pack.errors import pack_errors
from facezip.pack.geometry import read_head
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.viewer import scene as scenes
from facezip.viewer.scene import read_scene
from tests.facezip.conftest import random_character, random_model
from tests.facezip.viewer.models import DEPTH, random_maps, random_scans

GOLDEN = Path(__file__).parents[2] / "data"
NAMES = re.compile(
    r"head|activations|tiles_of_faces|tile_\d+\.(weights|masks|map_\d+\.(neutral(_low)?|(difference|original)_\d+|original))"
)
CASES = {
    "one albedo": {"maps": ("albedo",)},
    "three maps on two tiles": {"tiles": (1001, 1012)},
    "16 bits": {"bits": 16},
    "six differences": {"slots": 6},
    "three differences": {"slots": 3},
    "uniform weights": {"weights": (1, 1)},
    "six masks on two tiles": {"masks": 6, "slots": 6, "tiles": (1001, 1012)},
    "a range, two channels and grey": {
        "maps": ("albedo", DEPTH, Map("flow", "data")), "channels": {"albedo": 1, "flow": 2},
    },
}  # fmt: skip


def array(scene, name, dtype):
    return np.frombuffer(zlib.decompress(scene.assets[f"{name}.zlib"]()), dtype)


def image(scene, name):
    texels = np.asarray(Image.open(io.BytesIO(scene.assets[f"{name}.png"]())))
    return texels.reshape(*texels.shape[:2], -1)


def written(model, folder, **options):
    folder.mkdir(exist_ok=True)
    write_pack(model, folder / "a.facezip", **options)
    return folder / "a.facezip"


def combined(scene, t, betas):
    """The weight map ``(h, w, 4 L)`` of a blend, from the scene alone."""
    document = scene.document
    tile, layers = document.tiles[t], -(-document.slots // 4)
    if document.fours is not None:
        masks = array(scene, f"tile_{t}.masks", "u1").reshape(document.fours, *tile.weight_size, 4) / 255
        activations = array(scene, "activations", "<f2").reshape(len(betas), layers, document.fours, 4, 4)
        sums = np.einsum("n,nlfks,fhwk->hwls", betas, activations.astype(float), masks)
        return sums.reshape(*tile.weight_size, -1)[..., : document.slots]
    stored = array(scene, f"tile_{t}.weights", "<f4" if document.uniform else "u1").astype(float)
    stored = stored.reshape(layers, len(betas), *tile.weight_size, 4) / (1 if document.uniform else 255)
    sums = np.einsum("n,lnhwc->hwlc", betas, stored).reshape(*tile.weight_size, -1)[..., : document.slots]
    return sums * tile.weight_span + np.multiply(tile.weight_offset, np.sum(betas))


def enlarged(low, size):
    """Bilinear with clamped borders, as a GPU samples at the centres of ``size`` texels."""
    for axis in (0, 1):
        place = np.clip((np.arange(size[axis]) + 0.5) * low.shape[axis] / size[axis] - 0.5, 0, low.shape[axis] - 1)
        first, share = np.floor(place).astype(int), (place % 1).reshape((-1, *[1] * (2 - axis)))
        second = np.minimum(first + 1, low.shape[axis] - 1)
        low = low.take(first, axis) * (1 - share) + low.take(second, axis) * share
    return low


def shown(scene, t, m, betas):
    """The map of a blend as the page has to show it, in [0, 1], from the scene alone."""
    document, stem = scene.document, f"tile_{t}.map_{m}"
    kind, texture = document.maps[m], document.tiles[t].textures[m]
    neutral = image(scene, f"{stem}.neutral") / 255
    if texture.neutral_bits == 16:
        neutral = (256 * neutral + image(scene, f"{stem}.neutral_low") / 255) / 257
    channels, normal = kind.channels, kind.encoding == "normal"
    if normal:
        across = 2 * neutral[..., :2] - 1
        neutral = across / np.sqrt(1 - np.square(across).sum(axis=2, keepdims=True))
    weights = enlarged(combined(scene, t, betas), texture.size)
    for i, span in enumerate(texture.difference_span):
        difference = image(scene, f"{stem}.difference_{i}")[..., :channels] / 255 - document.difference_zero
        neutral = neutral + weights[..., i, None] * np.array(span)[:channels] * difference
    if not normal:
        return np.clip(neutral, 0, 1)
    slopes = np.clip(neutral, -document.max_slope, document.max_slope)
    vectors = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=2)
    return 0.5 + 0.5 * vectors / np.linalg.norm(vectors, axis=2, keepdims=True)


def expected(model, kind, tile, blend):
    values = model.blend(blend, map=kind.name, tile=tile)
    return (values - kind.low) / (kind.high - kind.low)


def test_a_scene_of_masks_holds_no_weight_map_and_states_their_range(tmp_path):
    pack = written(random_maps(tiles=(1001, 1012), masks=6), tmp_path)
    model, scene = read_pack(pack), read_scene(pack)
    assert not [name for name in scene.assets if "weights" in name]
    largest = max(np.abs(maps).max() for maps in model.weights.values())
    assert scene.document.weight_range == pytest.approx(largest)


@pytest.mark.parametrize("case", CASES)
def test_a_scene_holds_the_blend_of_every_map_on_every_tile(tmp_path, case):
    pack = written(random_maps(**CASES[case]), tmp_path)
    model, scene = read_pack(pack), read_scene(pack)
    betas = (0.5, -0.25, 1.0)
    blend = dict(zip(model.expressions, betas, strict=True))
    for t, tile in enumerate(model.tiles):
        for m, kind in enumerate(model.maps):
            np.testing.assert_allclose(shown(scene, t, m, betas), expected(model, kind, tile, blend), atol=1e-4)


@pytest.mark.parametrize("pack", ["pack-1/golden.facezip", "pack-2/golden.facezip"])
def test_the_meshes_of_old_packs_are_there(pack):
    model, scene = read_pack(GOLDEN / pack), read_scene(GOLDEN / pack)
    topology, neutral, vertices = read_head(zlib.decompress(scene.assets["head.zlib"]()), model.expressions)
    np.testing.assert_array_equal(topology.faces, model.meshes.topology.faces)
    np.testing.assert_array_equal(neutral, model.meshes.neutral)
    np.testing.assert_allclose(vertices, model.meshes.vertices, atol=1e-5 * np.ptp(neutral))


def test_the_files_of_a_pack_are_shown_as_they_are(tmp_path):
    pack = written(random_maps(), tmp_path)
    scene = read_scene(pack)
    assert zlib.decompress(scene.assets["head.zlib"]()) == (pack / "head.glb").read_bytes()
    assert scene.assets["tile_0.map_1.neutral.png"]() == (pack / "normal.1001.neutral.png").read_bytes()


def test_every_face_is_drawn_with_the_tile_of_its_chart(tmp_path):
    tiles = (1001, 1002, 1011)
    pack = written(random_maps(tiles=tiles), tmp_path)
    topology = read_pack(pack).meshes.topology
    places = array(read_scene(pack), "tiles_of_faces", np.uint8)
    for number, chart in enumerate(charts(topology, tiles)):
        np.testing.assert_array_equal(topology.faces[places == number], chart.faces)


def test_no_name_of_an_asset_comes_out_of_a_pack(tmp_path):
    model = random_maps(maps=("albedo", Map("neutral_low", "data")))
    hostile = replace(model, expressions=("tile_0.weights.zlib", "<script>", "original_9"))
    pack = written(hostile, tmp_path, name="../b")
    assets = read_scene(pack).assets
    assert all(NAMES.fullmatch(name.rsplit(".", 1)[0]) for name in assets)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_originals_come_in_the_order_of_the_pack(tmp_path, dtype):
    character = random_character(dtype=dtype)
    reversed_names = character.expressions[::-1]
    model = random_model(size=(32, 32), weights=(4, 4), expressions=5)
    scene = read_scene(written(replace(model, expressions=reversed_names), tmp_path), character)
    for n, name in enumerate(reversed_names):
        texture = np.rint(character.texture(name) * 255)
        np.testing.assert_array_equal(image(scene, f"tile_0.map_0.original_{n}"), texture)


def test_originals_and_errors_are_there_for_every_map_and_tile(tmp_path):
    pack = written(random_maps(tiles=(1001, 1002)), tmp_path)
    character = random_scans(read_pack(pack))
    scene, errors = read_scene(pack, character), pack_errors(character, pack)
    means = [errors[name].mean for name in ("albedo", "normal", "roughness")]
    assert [entry.error for entry in scene.document.maps] == means
    normals = character.texture("expr_1", map="normal", tile=1002)
    np.testing.assert_allclose(image(scene, "tile_1.map_1.original_1") / 127.5 - 1, normals, atol=1 / 255 + 1e-6)


def test_without_a_character_there_are_no_originals(tmp_path):
    scene = read_scene(written(random_maps(), tmp_path))
    assert not scene.document.originals
    assert [entry.error for entry in scene.document.maps] == [None] * 3
    assert not any("original" in name for name in scene.assets)


def test_a_pack_without_meshes_has_a_scene(tmp_path):
    scene = read_scene(written(random_model(), tmp_path))
    assert scene.document.mesh is None
    assert "head.zlib" not in scene.assets


def test_poses_are_named_blends_and_every_expression_is_one(tmp_path):
    names = ("constructor", "mouthSmileLeft", "b")
    document = read_scene(written(replace(random_maps(), expressions=names), tmp_path)).document
    poses = {pose.name: {names[n]: weight for n, weight in pose.weights} for pose in document.poses}
    assert all(poses[name] == {name: 1.0} for name in names)
    assert poses["constructor and mouthSmileLeft"] == {"constructor": 0.5, "mouthSmileLeft": 0.5}


def others(character):
    """Characters that a pack of ``character`` was not made from, and what is said of each."""
    fewer = replace(character, expressions=character.expressions[:-1])
    more = replace(character, expressions=(*character.expressions, "yawn"))
    key = (ALBEDO, 1001)
    smaller = replace(character.stacks[key], neutral=character.stacks[key].neutral[::2, ::2])
    return {
        "has expression 'expr_2', which sheet has not": fewer,
        "has no expression 'yawn'": more,
        "has normal on tile 1001, which sheet has not": character.only("albedo", "roughness"),
        "its albedo on tile 1001 has 40x24": replace(character, stacks={**character.stacks, key: smaller}),
    }


def test_the_character_of_another_pack_is_refused(tmp_path):
    pack = written(random_maps(tiles=(1001, 1002)), tmp_path)
    character = replace(random_scans(read_pack(pack)), name="sheet")
    for words, other in others(character).items():
        with pytest.raises(FaceZipError, match=rf"a\.facezip: {words}"):
            read_scene(pack, other)


@pytest.mark.parametrize(("encoding", "channels"), [("srgb", 2), ("srgb", 4), ("data", 4)])
def test_what_is_no_picture_is_refused(tmp_path, encoding, channels):
    model = random_maps(maps=("albedo", Map("odd", encoding)), channels={"odd": channels})
    with pytest.raises(FaceZipError, match=f"its odd has {channels} channels"):
        read_scene(written(model, tmp_path))


def contents(scene):
    return scene.document, {name: content() for name, content in scene.assets.items()}


def test_a_scene_is_of_one_pack_whatever_becomes_of_its_folder(tmp_path, monkeypatch):
    models = random_maps(), replace(random_maps(slots=3), method="pca")
    pack, other = (written(model, tmp_path / str(n)) for n, model in enumerate(models))
    last, read, times = contents(read_scene(other)), scenes.read_stored, []

    def replaced(folder, manifest):
        found = read(folder, manifest)
        if not times:
            assert exchange(pack, other)
        times.append(1)
        return found

    monkeypatch.setattr(scenes, "read_stored", replaced)
    scene = read_scene(pack)
    shutil.rmtree(pack)
    assert contents(scene) == last
    assert len(times) == 2
