"""What materials of a glTF state about a face's textures is what is read, or said to be left out."""

import cmath
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from facezip import FaceZipError
from facezip.files.images import to_float
from facezip.files.srgb import decode_srgb, encode_srgb
from tests.facezip.character.gltfs import Scene, assert_same, corners, scans, words

PLACED = "KHR_texture_transform"
share = st.floats(0.05, 1).map(lambda value: round(value, 3))
some = st.floats(-1.5, 1.5).map(lambda value: round(value, 3))


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("gltf")


@st.composite
def transforms(draw):
    """A texture transform, some of it unsaid."""
    wide, high = (round(draw(st.floats(0.25, 3)), 3) * draw(st.sampled_from([-1, 1])) for _ in "uv")
    stated = {"offset": [draw(some), draw(some)], "rotation": draw(some), "scale": [wide, high]}
    return {key: value for key, value in stated.items() if draw(st.booleans())}


def transformed(uv, stated):
    """UVs, v down, under a transform: scaled, then turned as complex numbers are by a conjugate, then moved."""
    wide, high = stated.get("scale", (1, 1))
    turn = cmath.exp(-1j * stated.get("rotation", 0))
    points = (uv[..., 0] * wide + 1j * uv[..., 1] * high) * turn
    return np.stack([points.real, points.imag], axis=-1) + stated.get("offset", (0, 0))


def untransformed(uv, stated):
    """Inverse of :func:`transformed`."""
    points = uv - np.array(stated.get("offset", (0, 0)))
    points = (points[..., 0] + 1j * points[..., 1]) * cmath.exp(1j * stated.get("rotation", 0))
    return np.stack([points.real, points.imag], axis=-1) / stated.get("scale", (1, 1))


def uv_of(scene):
    """UVs of the corners of the character of a scene, v down."""
    return corners(scene.character)[1].reshape(-1, 2).astype(float) * (1, -1) + (0, 1)


LISTED = st.sampled_from([[], ["extensionsUsed"], ["extensionsUsed", "extensionsRequired"]])


@settings(deadline=None, max_examples=40)
@given(transforms(), LISTED, st.integers(0, 2))
def test_any_texture_transform_is_that_of_the_uvs(place, stated, listed, number):
    scene = Scene(scans())
    np.testing.assert_allclose(transformed(untransformed(uv_of(scene), stated), stated), uv_of(scene), atol=1e-9)
    scene.document |= {key: [PLACED] for key in listed}
    for info in scene.textures():
        info["extensions"] = {PLACED: {**stated, "texCoord": number}}
    scene.face["attributes"]["TEXCOORD_0"] = scene.array(np.full_like(uv_of(scene), 0.3))
    scene.face["attributes"][f"TEXCOORD_{number}"] = scene.array(untransformed(uv_of(scene), stated))
    read = scene.read(place)
    assert_same(read, scans(), atol=1e-5)
    turned = transformed(np.array([[0.25, 0.75], [0.5, 0.1]]), stated)
    is_none = np.allclose(turned, [[0.25, 0.75], [0.5, 0.1]])
    assert is_none or words(read) == ["UVs are moved as its texture transform says"]


def test_the_transform_is_that_of_three_js():
    """Of its GLTFLoader: u' = sx c u + sy s v + x, v' = -sx s u + sy c v + y."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        x, y, turn, wide, high = rng.normal(size=5)
        u, v = uv = rng.random(2)
        c, s = np.cos(turn), np.sin(turn)
        stated = {"offset": [x, y], "rotation": turn, "scale": [wide, high]}
        expected = [wide * c * u + high * s * v + x, -wide * s * u + high * c * v + y]
        np.testing.assert_allclose(transformed(uv, stated), expected)


@settings(deadline=None, max_examples=10)
@given(st.integers(1, 3))
def test_the_set_of_uvs_is_the_one_that_textures_name(place, number):
    scene = Scene(scans())
    attributes = scene.face["attributes"]
    attributes[f"TEXCOORD_{number}"] = attributes["TEXCOORD_0"]
    attributes["TEXCOORD_0"] = scene.array(np.full_like(uv_of(scene), 0.3))
    for info in scene.textures():
        info["texCoord"] = number
    read = scene.read(place)
    assert_same(read, scans())
    assert not read.notes


def test_uvs_that_are_not_there_are_named(tmp_path):
    scene = Scene(scans())
    for info in scene.textures():
        info["texCoord"] = 1
    with pytest.raises(FaceZipError, match=r"no UVs \(TEXCOORD_1\)"):
        scene.read(tmp_path)


@settings(deadline=None, max_examples=30)
@given(transforms(), st.sampled_from(["neutral", "expr_0", "expr_1", "mask"]))
def test_textures_that_lie_otherwise_than_the_neutrals_are_refused(place, stated, name):
    moved = transformed(np.array([[0.25, 0.75], [0.5, 0.1]]), stated)
    assume(not np.allclose(moved, [[0.25, 0.75], [0.5, 0.1]]))
    scene = Scene(scans())
    (material,) = scene.materials(name)
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {PLACED: stated}
    with pytest.raises(FaceZipError, match=rf"texture of '\w+' lies otherwise.*{PLACED} or texCoord.*bake"):
        scene.read(place)


@settings(deadline=None, max_examples=30)
@given(st.integers(-3, 3), st.integers(-3, 3), st.booleans(), st.integers(0, 1000))
def test_charts_in_other_unit_squares_show_what_a_repeated_texture_shows(place, across, down, apart, seed):
    scene = Scene(scans())
    rng = np.random.default_rng(seed)
    shift = rng.integers(-2, 3, (len(uv_of(scene)) // 3, 2)).repeat(3, axis=0) if apart else 0
    moved = uv_of(scene) + np.array([across, down]) + shift
    scene.face["attributes"]["TEXCOORD_0"] = scene.array(moved)
    read = scene.read(place)
    assert_same(read, scans(), atol=1e-5)
    assert bool(words(read)) == bool((moved < 0).any() or (moved > 1).any())


@pytest.mark.parametrize(("wrap", "said"), [(10497, "reaches over the border"), (33648, "mirrored"), (33071, None)])
def test_what_a_sampler_shows_beyond_a_texture_is_shown_or_refused(tmp_path, wrap, said):
    scene = Scene(scans())
    scene.document["samplers"] = [{"wrapS": wrap, "wrapT": wrap}]
    for texture in scene.document["textures"]:
        texture["sampler"] = 0
    scene.face["attributes"]["TEXCOORD_0"] = scene.array(uv_of(scene) + 0.125)
    if said is None:
        np.testing.assert_allclose(corners(scene.read(tmp_path))[1], corners(scans())[1] + (0.125, -0.125), atol=1e-6)
    else:
        with pytest.raises(FaceZipError, match=said):
            scene.read(tmp_path)


@settings(deadline=None, max_examples=15)
@given(
    st.lists(st.tuples(share, share, share), min_size=3, max_size=3),
    st.sampled_from([np.uint8, np.uint16]),
    st.sampled_from(["pbrMetallicRoughness", "KHR_materials_pbrSpecularGlossiness"]),
)
def test_a_base_colour_factor_multiplies_light(place, factors, dtype, way):
    character = scans(dtype=dtype)
    scene = Scene(character)
    for material, factor in zip(scene.materials("neutral", "expr_0", "expr_1"), factors, strict=True):
        if way == "pbrMetallicRoughness":
            material[way]["baseColorFactor"] = [*factor, 1]
        else:
            texture = material.pop("pbrMetallicRoughness")["baseColorTexture"]
            material["extensions"] = {way: {"diffuseTexture": texture, "diffuseFactor": [*factor, 1]}}
    read = scene.read(place)
    every = np.concatenate([character.first.neutral[None], character.first.textures])
    found = np.concatenate([read.first.neutral[None], read.first.textures])
    assert found.dtype == dtype
    whole = np.iinfo(dtype).max
    expected = encode_srgb(decode_srgb(to_float(every)) * np.array(factors, np.float32)[:, None, None])
    np.testing.assert_allclose(found / whole, expected, rtol=0, atol=0.501 / whole + 2e-7)
    assert words(read) == ["colours are multiplied by the base colour factor"]


@pytest.mark.parametrize("factor", [[0.5, 0.5, 0.5, 1], [0.5, 0.25, 1, 1]])
def test_grey_becomes_coloured_only_where_a_factor_is(tmp_path, factor):
    character = scans(mask=False)
    first = character.first
    grey = replace(first, neutral=first.neutral[..., :1], textures=first.textures[..., :1])
    character = replace(character, stacks=dict.fromkeys(character.stacks, grey))
    scene = Scene(character)
    scene.materials("neutral")[0]["pbrMetallicRoughness"]["baseColorFactor"] = factor
    read = scene.read(tmp_path)
    channels = 1 if factor[0] == factor[1] else 3
    assert read.first.channels == channels
    np.testing.assert_array_equal(read.first.textures, np.repeat(grey.textures, channels, axis=3))
    light = decode_srgb(to_float(grey.neutral)) * np.array(factor[:channels], np.float32)
    np.testing.assert_array_equal(read.first.neutral, np.rint(encode_srgb(light) * 255))


def test_a_factor_of_one_and_the_alpha_of_an_opaque_face_are_nothing(tmp_path):
    scene = Scene(scans())
    for material in scene.materials():
        material["pbrMetallicRoughness"]["baseColorFactor"] = [1, 1, 1, 0.25]
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert not read.notes


def test_the_faces_factor_holds_for_textures_of_no_material(tmp_path):
    scene = Scene(scans())
    scene.materials("neutral")[0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.5, 0.5, 0.5, 1]
    whole = scene.read(tmp_path)
    np.testing.assert_array_equal(whole.first.textures, scans().first.textures)
    for material in scene.materials("expr_0", "expr_1"):
        material["name"] = "unused"
    read = scene.read(tmp_path)
    light = decode_srgb(to_float(scans().first.textures)) * np.float32(0.5)
    np.testing.assert_array_equal(read.first.textures, np.rint(encode_srgb(light) * 255))


@pytest.mark.parametrize("factor", [[2, 1, 1, 1], [1, 1, 1], "red", [1, 1, None, 1], [10**400] * 4])
def test_a_factor_that_is_none_is_refused(tmp_path, factor):
    scene = Scene(scans())
    scene.materials("neutral")[0]["pbrMetallicRoughness"]["baseColorFactor"] = factor
    with pytest.raises(FaceZipError, match="base colour factor|not valid glTF|JSON"):
        scene.read(tmp_path)


def shaded(scene, seed, kinds=("normal", "roughness"), factor=1.0, scale=1.0):
    """Give all materials but the mask's roughness and normals; what they hold, by kind."""
    rng = np.random.default_rng(seed)
    size = (3, 16, 16, 3)
    rough = rng.integers(0, 256, size).astype(np.uint8)
    slopes = rng.uniform(-1, 1, (3, 16, 16, 2))
    vectors = np.concatenate([slopes, np.ones((3, 16, 16, 1))], axis=3)
    vectors /= np.linalg.norm(vectors, axis=3, keepdims=True)
    bumps = np.rint((vectors / 2 + 0.5) * 65535).astype(np.uint16)
    for k, material in enumerate(scene.materials("neutral", *scene.character.expressions)):
        if "roughness" in kinds:
            info = {"index": scene.texture(rough[k])}
            material["pbrMetallicRoughness"] |= {"metallicRoughnessTexture": info, "roughnessFactor": factor}
        if "normal" in kinds:
            material["normalTexture"] = {"index": scene.texture(bumps[k]), "scale": scale}
    return rough, slopes


@settings(deadline=None, max_examples=8)
@given(st.integers(0, 1000), share, st.floats(-3, 3))
def test_roughness_is_the_green_channel_and_normals_have_their_scale(place, seed, factor, scale):
    scene = Scene(scans())
    rough, slopes = shaded(scene, seed, factor=factor, scale=scale)
    read = scene.read(place)
    assert [kind.name for kind in read.maps] == ["albedo", "normal", "roughness"]
    assert_same(replace(read, stacks={key: read.stacks[key] for key in scans().stacks}), scans())
    found = np.concatenate([read.stacks["roughness", 1001].neutral[None], read.stacks["roughness", 1001].textures])
    np.testing.assert_allclose(found[..., 0], rough[..., 1] * factor, rtol=0, atol=0.501)
    mask = read.first.mask.repeat(2, axis=0).repeat(2, axis=1)
    np.testing.assert_array_equal(read.stacks["normal", 1001].mask, mask)
    for k, name in enumerate(("neutral", *read.expressions)):
        vectors = read.texture(name, "normal")
        inside = mask > 0
        np.testing.assert_allclose((vectors[..., :2] / vectors[..., 2:])[inside], scale * slopes[k][inside], atol=2e-3)
    assert not read.notes


@pytest.mark.parametrize("kind", ["normal", "roughness"])
@pytest.mark.parametrize("why", ["has none", "on other UVs"])
@pytest.mark.parametrize("name", ["neutral", "expr_1"])
def test_a_map_that_not_all_have_is_left_out_and_that_is_said(tmp_path, kind, why, name):
    scene = Scene(scans())
    shaded(scene, 0, (kind,))
    last = scene.materials(name)[0]
    shading = last["pbrMetallicRoughness"]
    holder, key = (last, "normalTexture") if kind == "normal" else (shading, "metallicRoughnessTexture")
    if why == "has none":
        holder.pop(key)
    else:
        holder[key]["extensions"] = {PLACED: {"scale": [4, 4]}}
    read = scene.read(tmp_path)
    assert_same(read, scans())
    (said,) = words(read)
    assert f"textures of {kind} are left out: '{name}'" in said
    assert why in said


LEFT_OUT = {
    "occlusionTexture": lambda m: m.update(occlusionTexture={"index": 0}),
    "emissiveTexture": lambda m: m.update(emissiveTexture={"index": 0}),
    "emissiveFactor": lambda m: m.update(emissiveFactor=[0.1, 0, 0]),
    "specularTexture": lambda m: m.update(extensions={"KHR_materials_specular": {"specularTexture": {"index": 0}}}),
    "alphaMode BLEND": lambda m: m.update(alphaMode="BLEND"),
    "alphaMode MASK": lambda m: m.update(alphaMode="MASK"),
}


@pytest.mark.parametrize("said", LEFT_OUT)
@pytest.mark.parametrize("name", ["neutral", "expr_1"])
def test_what_else_a_material_shows_is_said_to_be_left_out(tmp_path, said, name):
    scene = Scene(scans())
    LEFT_OUT[said](scene.materials(name)[0])
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert [said in each for each in words(read)] == [True]


@pytest.mark.parametrize(("colour", "asks"), [([1, 1, 1, 0.5], []), ([1, 0.5, 1, 1], [True])])
def test_vertex_colours_are_said_to_be_left_out_unless_they_are_white(tmp_path, colour, asks):
    scene = Scene(scans())
    scene.face["attributes"]["COLOR_0"] = scene.array(np.tile(colour, (96, 1)))
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert [note.asks for note in read.notes if "COLOR_0" in note.words] == asks
    assert len(read.notes) == len(asks)


def test_weights_that_are_not_zero_are_said(tmp_path):
    scene = Scene(scans())
    scene.document["meshes"][0]["weights"] = [0, 0.5]
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert [note.asks for note in read.notes] == [True]


@pytest.mark.parametrize("kind", ["materials", "images"])
def test_two_textures_of_one_name_are_not_guessed_at(tmp_path, kind):
    scene = Scene(scans())
    scene.material("expr_0" if kind == "materials" else "", np.zeros((8, 8, 3), np.uint8))
    if kind == "images":
        scene.document["images"][-1]["name"] = "expr_0"
        for entry in [*scene.materials("expr_0"), *scene.document["textures"]]:
            entry["name"] = ""
    with pytest.raises(FaceZipError, match=f"2 of its {kind} are called 'expr_0'"):
        scene.read(tmp_path)


def test_names_compare_in_one_form_whatever_their_case(tmp_path):
    character = replace(scans(), expressions=("Élan", "Smile"))
    scene = Scene(character)
    for kind in ("materials", "textures", "images"):
        for entry, name in zip(scene.document[kind][1:], ("e\u0301lan", "smile"), strict=False):
            entry["name"] = name
    assert_same(scene.read(tmp_path), character)


def test_a_mask_is_read_as_it_is_in_a_folder(tmp_path):
    region = scans().first.mask
    for texels, mask, said in (
        (np.full((1, 1, 1), 255, np.uint8), np.ones_like(region), "1x1 of one value; taken for that constant, 8x8"),
        (np.stack([0 * region, region, 0 * region], axis=2), region, "its channel G is the mask"),
    ):
        scene = Scene(scans(mask=False))
        scene.material("mask", texels)
        read = scene.read(tmp_path)
        np.testing.assert_array_equal(read.first.mask, mask)
        assert [(note.file, note.words) for note in read.notes] == [("image 3 ('mask')", said)]
    for texels, said in ((region[:4, :4, None], "4x4, the textures differ"), (0 * region[:, :, None], "black")):
        scene = Scene(scans(mask=False))
        scene.material("mask", texels)
        with pytest.raises(FaceZipError, match=rf"glb: image 3 \('mask'\): .*{said}"):
            scene.read(tmp_path)
