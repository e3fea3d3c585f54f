"""Of an OBJ of several materials the face is read, whatever else is in it, and the rest is named; never in silence."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import FaceZipError, load_character, save_character
from facezip.character.examination import examine_character
from facezip.files.images import write_texture
from facezip.files.obj import read_obj
from tests.facezip.character.gltfs import assert_same, scans, words

QUAD = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


@dataclass(frozen=True)
class Part:
    """A quad before the face, with UVs over the whole square, or over ``spread`` times as much."""

    material: str
    image: str | None = None
    is_first: bool = False
    spread: float = 1


def write(folder, parts, face="skin", face_image="neutral.png", unnamed=()):
    """The scans in a new folder, with parts in every mesh, and no materials in the meshes ``unnamed``."""
    save_character(scans(), folder)
    for path in folder.glob("*.obj"):
        vertices, topology = read_obj(path)
        blocks = [(face, vertices, topology.uv, np.stack([topology.faces, topology.face_uv], axis=2))]
        for number, part in enumerate(parts):
            corners = np.c_[QUAD / 9 + number, np.full(4, 0.5)]
            block = part.material, corners, part.spread * (QUAD + 1) / 2, np.arange(4)[None, :, None].repeat(2, axis=2)
            blocks.insert(0 if part.is_first else len(blocks), block)
        path.write_text("\n".join(lines(blocks, path.stem not in unnamed)) + "\n")
    images = [(face, face_image), *((part.material, part.image) for part in parts)]
    stated = [f"newmtl {name}\n" + (f"map_Kd {image}\n" if image else "") for name, image in images]
    if any(image for _, image in images):
        (folder / "head.mtl").write_text("".join(stated))
    return folder


def lines(blocks, named):
    at = at_uv = 1
    for name, vertices, uv, faces in blocks:
        yield from ([f"usemtl {name}"] if named else [])
        yield from ("v {:.9g} {:.9g} {:.9g}".format(*row) for row in vertices.tolist())
        yield from ("vt {:.9g} {:.9g}".format(*row) for row in uv.tolist())
        for face in faces.tolist():
            yield "f " + " ".join(f"{at + vertex}/{at_uv + corner}" for vertex, corner in face)
        at, at_uv = at + len(vertices), at_uv + len(uv)


@st.composite
def others(draw):
    """Some parts besides the face, with images of their own or none."""
    names = draw(st.lists(st.sampled_from(["eyes", "teeth", "Lash", "m 1", "blinn2"]), min_size=1, unique=True))
    return [Part(name, draw(st.sampled_from([None, f"{name}_color.png"])), draw(st.booleans())) for name in names]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("parts")


numbers = iter(range(10**6))


@settings(deadline=None, max_examples=25)
@given(others(), st.sampled_from(["neutral.png", "maps/NEUTRAL.PNG", "smile.png -", "expr_0.png"]), st.booleans())
def test_the_material_of_the_characters_textures_is_the_face(place, parts, image, beside):
    image = image.removesuffix(" -").replace("smile", "expr_1")
    folder = write(place / f"{next(numbers)}", parts, face_image=image)
    images = [part.image for part in parts if part.image]
    for name in images if beside else ():
        write_texture(folder / name, np.zeros((4, 4, 3), np.uint8))
    read = load_character(folder)
    assert_same(read, scans())
    said = {note.file: note.words for note in read.notes}
    assert all(f"'{part.material}'" in said["neutral.obj"] for part in parts)
    assert {name for name in said if name != "neutral.obj"} == ({*images} if beside else set())
    assert all("left out: a texture of the material" in said[name] for name in said if name != "neutral.obj")


@settings(deadline=None, max_examples=15)
@given(others(), st.sampled_from(["skin", "SKIN"]))
def test_a_part_that_is_named_is_the_face(place, parts, part):
    folder = write(place / f"{next(numbers)}", parts, face_image=None)
    (folder / "character.toml").write_text(f'part = "{part}"')
    read = load_character(folder)
    assert_same(read, scans())
    assert "the face is of the material 'skin'" in words(read)[0]


def test_what_names_alone_tell_is_told(tmp_path):
    folder = write(tmp_path / "a", [Part("eye_L"), Part("Teeth")], face="M_1", face_image=None)
    assert_same(load_character(folder), scans())


def test_what_nothing_tells_is_asked(tmp_path):
    folder = write(tmp_path / "a", [Part("blinn2")], face="blinn1", face_image=None)
    with pytest.raises(
        FaceZipError, match=r"neutral\.obj: each of its materials 'blinn1', 'blinn2' may be the face"
    ) as asked:
        load_character(folder)
    assert 'in character.toml: part = "blinn1"' in str(asked.value)
    (folder / "character.toml").write_text('part = "chin"')
    with pytest.raises(FaceZipError, match=r"no material 'chin', as character\.toml says; it has 'blinn1', 'blinn2'"):
        load_character(folder)


def by_halves(folder, images=()):
    """The scans with a material for each half of the triangles, which lie beside each other on the texture."""
    save_character(scans(), folder)
    for path in folder.glob("*.obj"):
        _, topology = read_obj(path)
        left = topology.uv[topology.face_uv].mean(axis=1)[:, 0] < 0.5
        text = path.read_text().splitlines()
        faces = [line for line in text if line.startswith("f ")]
        kept = [line for line in text if not line.startswith("f ")]
        for name, mine in (("left", left), ("right", ~left)):
            kept += [f"usemtl {name}", *(face for face, own in zip(faces, mine, strict=True) if own)]
        path.write_text("\n".join(kept) + "\n")
    if images:
        (folder / "head.mtl").write_text("".join(f"newmtl {name}\nmap_Kd {image}\n" for name, image in images))
    return folder


@pytest.mark.parametrize(
    "images",
    [
        [],
        [("left", "neutral.png"), ("right", "neutral.png")],
        [("left", "skin.jpg"), ("right", "skin.jpg")],
    ],
)
def test_materials_that_share_the_texture_are_one_face(tmp_path, images):
    read = load_character(by_halves(tmp_path / "a", images))
    assert len(read.meshes.topology.faces) == len(scans().meshes.topology.faces)
    assert not read.notes


def test_a_mesh_without_materials_is_cut_as_the_neutral_is(tmp_path):
    folder = write(tmp_path / "a", [Part("eyes", "eyes.png")], unnamed=("expr_0",))
    assert_same(load_character(folder), scans())


def test_a_mesh_of_other_materials_is_refused_by_their_names(tmp_path):
    folder = write(tmp_path / "a", [Part("eyes", "eyes.png")])
    path = folder / "expr_1.obj"
    path.write_text(path.read_text().replace("usemtl skin", "usemtl skin.001"))
    with pytest.raises(FaceZipError, match=r"expr_1\.obj: has the materials 'skin\.001', 'eyes'.*is of 'skin'"):
        load_character(folder)


def test_a_texture_that_no_material_names_is_still_missed(tmp_path):
    folder = write(tmp_path / "a", [Part("eyes", "eyes.png")])
    write_texture(folder / "frown.png", np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(FaceZipError, match=r"frown\.obj"):
        load_character(folder)


def test_what_is_left_out_is_no_reason_that_a_character_cannot_be_read(tmp_path):
    folder = write(tmp_path / "scans", [Part("eyes", spread=2.5)])
    assert_same(load_character(folder), scans())
    (folder / "expr_0.png").write_bytes(b"no image")
    found = examine_character(folder)
    (refusal,) = found.refusals
    assert "expr_0.png: " in refusal.words
    assert {row.size for row in found.rows if row.what == "mesh"} == {
        row.size for row in examine_character(write(tmp_path / "whole", [Part("eyes")])).rows if row.what == "mesh"
    }
