"""One part of a glTF is the face, the others are named; and expressions are called as its morph targets are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import FaceZipError, load_character
from tests.facezip.character.gltfs import Scene, assert_same, scans, words


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("gltf")


def triangle(scene, material=None, targets=2):
    """A primitive beside the face."""
    points = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)])
    made = scene.primitive(points, points[:, :2], [0 * points + k / 9 for k in range(targets)], material)
    if material is None:
        made.pop("material")
    if not targets:
        made.pop("targets")
    return made


@st.composite
def avatars(draw):
    """A scene with parts besides the face, and what these are called."""
    scene, others = Scene(scans()), []
    for number in range(draw(st.integers(1, 4))):
        name = f"part {number}"
        texels = np.full((4, 4, 3), 200, np.uint8) if draw(st.booleans()) else None
        targets = draw(st.sampled_from([0, 2]))
        # With a texture of its own and the targets, only its name tells that it is not the face.
        name += draw(st.sampled_from([" teeth", "_EyeLeft", " Hair"])) if texels is not None and targets else ""
        material = scene.material(f"{name} of stuff", texels)
        if draw(st.booleans()):
            # All primitives of a mesh have the same targets.
            scene.document["meshes"][0]["primitives"].insert(draw(st.integers(0, 1)), triangle(scene, material, 2))
            others.append(f"{name} of stuff")
            if texels is not None and not targets:
                scene.document["materials"][material]["pbrMetallicRoughness"] = {}
        else:
            primitive = triangle(scene, material, targets)
            mesh = scene.mesh(name, [primitive], scene.character.expressions if targets else ())
            scene.show(mesh)
            others.append(name)
    return scene, others


@settings(deadline=None, max_examples=25)
@given(avatars())
def test_the_part_with_the_textures_is_the_face_and_the_others_are_named(place, case):
    scene, others = case
    read = scene.read(place)
    assert_same(read, scans())
    (said,) = words(read)
    assert all(f"'{name}'" in said for name in others)
    assert "left out" in said


def two_faces(textured=True):
    """A scene in which two meshes may be the face."""
    scene = Scene(scans())
    texels = np.full((8, 8, 3), 200, np.uint8) if textured else None
    mesh = scene.mesh("bust", [triangle(scene, scene.material("marble", texels))], scene.character.expressions)
    scene.show(mesh, name="pedestal")
    return scene


@pytest.mark.parametrize("part", ["head", "head node", "neutral", "HEAD", "0/0"])
@pytest.mark.parametrize("form", ["glb", "gltf, files beside"])
def test_the_face_is_chosen_by_the_name_of_its_mesh_node_or_material(tmp_path, part, form):
    path = two_faces().write(tmp_path, form)
    with pytest.raises(FaceZipError, match=r"'head', 'bust' may be the face; say which in character\.toml") as caught:
        load_character(path)
    assert 'part = "head"' in str(caught.value)
    (tmp_path / "character.toml").write_text(f'part = "{part}"')
    read = load_character(path)
    assert_same(read, scans())
    assert words(read) == ["the face is 'head'; left out: 'bust'"]
    (tmp_path / "character.toml").write_text('part = "pedestal"')
    assert len(load_character(path).meshes.topology.faces) == 1


def test_a_part_that_is_not_there_is_named_with_those_that_are(tmp_path):
    path = two_faces().write(tmp_path)
    (tmp_path / "character.toml").write_text('part = "chest"')
    with pytest.raises(FaceZipError, match=r"none of its parts is called 'chest'; it has 'head', 'bust'"):
        load_character(path)
    (tmp_path / "character.toml").write_text("part = 3")
    with pytest.raises(FaceZipError, match=r"character\.toml: part is the name of"):
        load_character(path)
    (tmp_path / "character.toml").write_text('ups = "z"')
    with pytest.raises(FaceZipError, match=r"character\.toml: 'ups' is not known"):
        load_character(path)


def test_variants_tell_the_face_among_parts_with_textures(tmp_path):
    scene = two_faces()
    mappings = [{"material": k + 1, "variants": [k]} for k in range(2)]
    scene.face["extensions"] = {"KHR_materials_variants": {"mappings": mappings}}
    variants = [{"name": name} for name in scene.character.expressions]
    scene.document["extensions"] = {"KHR_materials_variants": {"variants": variants}}
    assert_same(scene.read(tmp_path), scans())


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.integers(2, 4))
def test_primitives_of_one_material_are_one_face(place, seed, count):
    scene, whole = Scene(scans()), scans()
    owner = np.sort(np.random.default_rng(seed).integers(0, count, len(whole.meshes.topology.faces)))
    number = scene.document["accessors"][scene.face["attributes"]["POSITION"]]["count"]
    rows = np.arange(number, dtype=np.uint16).reshape(-1, 3)
    scene.document["meshes"][0]["primitives"] = [
        {**scene.face, "indices": scene.builder.array(rows[owner == k].reshape(-1, 1))} for k in np.unique(owner)
    ]
    read = scene.read(place)
    assert_same(read, whole)
    assert len(read.meshes.neutral) == len(whole.meshes.neutral)
    assert not read.notes


NAMES = st.lists(
    st.sampled_from(["smile", "jaw open", "Wink_L", "ümlaut", "aa", "b.c"]), min_size=2, max_size=2, unique=True
)
WAYS = ("mesh", "primitive", "targets", "old targets", "accessors")


@settings(deadline=None, max_examples=30)
@given(NAMES, st.sampled_from(WAYS), st.sampled_from(["", "Face.", "blendShape1."]))
def test_names_are_found_where_exporters_write_them(place, names, way, before):
    character = replace(scans(), expressions=tuple(names))
    scene = Scene(character)
    called = [before + name for name in names]
    scene.document["meshes"][0].pop("extras")
    if way == "mesh":
        scene.document["meshes"][0]["extras"] = {"targetNames": called}
    elif way == "primitive":
        scene.face["extras"] = {"targetNames": called}
    for target, name in zip(scene.face["targets"], called, strict=True):
        if way == "accessors":
            scene.document["accessors"][target["POSITION"]]["name"] = name
        elif "targets" in way:
            target["extra" if way.startswith("old") else "extras"] = {"name": name}
    assert_same(scene.read(place), replace(character, expressions=tuple(called)))


@pytest.mark.parametrize("name", ["Basis", "neutral", "Rest", "_neutral", "None", "000_Neutral", "rest pose"])
@pytest.mark.parametrize("has_material", [True, False])
def test_a_target_that_is_the_neutral_is_none(tmp_path, name, has_material):
    scene = Scene(scans())
    scene.face["targets"].insert(0, {"POSITION": scene.array(np.zeros((96, 3)))})
    scene.document["meshes"][0]["extras"]["targetNames"].insert(0, name)
    if not has_material:
        scene.face.pop("material")
        for entry in [*scene.materials("neutral"), scene.document["textures"][0], scene.document["images"][0]]:
            entry["name"] = name
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert words(read) == [f"'{name}' moves nothing and is taken for the neutral"]


def test_a_target_called_neutral_that_moves_is_no_neutral(tmp_path):
    scene = Scene(scans())
    scene.document["meshes"][0]["extras"]["targetNames"][0] = "neutral"
    with pytest.raises(FaceZipError, match="'neutral' cannot be a file name; rename it"):
        scene.read(tmp_path)
