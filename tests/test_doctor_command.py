"""``facezip doctor``: what is read from where, all reasons at once, and what would break an export."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facezip.character.loading import save_character
from facezip.commands.doctor import command
from facezip.errors import ErrorCode, ExitCode
from facezip.export import TARGETS
from facezip.export.documents.tiles import TilesDocument
from facezip.export.record import checksum, with_record
from facezip.files.documents import read_document
from facezip.files.images import read_texture, write_texture
from facezip.fit.methods import compress
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_character, random_model
from tests.facezip.export.gains import regions_in
from tests.facezip.files import broken
from tests.facezip.surfaces import random_surface


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    """What a process of its own changes, :mod:`tests.facezip.files.test_apart` shows."""
    monkeypatch.setattr("facezip.commands.doctor.apart", lambda work, *args: work(*args))


def doctor(path):
    """Exit code and document; the lines for people say the same."""
    done = CliRunner().invoke(command, [str(path), "--json"], standalone_mode=False)
    assert done.exception is None, done.exception
    document = json.loads(done.stdout)
    lines = CliRunner().invoke(command, [str(path)], standalone_mode=False).stdout
    for refusal in document["refusals"]:
        assert refusal["words"] in lines
    for note in document["notes"]:
        assert note["words"] in lines
    return done.return_value, document


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A character of two maps on two tiles, its pack, and exports of it; never changed."""
    place = tmp_path_factory.mktemp("doctor")
    character = random_surface(expressions=3, side=32, maps=("roughness",), tiles=(2, 1))
    save_character(character, place / "scans")
    write_pack(compress(character, "refined", differences=2, weight_scale=8), place / "pack.facezip")
    for target in ("gltf", "unity", "godot"):
        TARGETS[target](place / "pack.facezip", place / target)
    return place


def test_an_image_that_crashes_its_decoder_is_one_finding_of_the_command(scans, tmp_path):
    broken.mark(scans / "neutral.roughness.1002.png", b"crash")
    call = [sys.executable, "-c", "from facezip.cli import main; main()", "doctor", scans, "--json"]
    surroundings = os.environ | broken.surroundings(tmp_path)
    done = subprocess.run(call, env=surroundings, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == ExitCode.BAD_INPUT, done.stderr
    (refusal,) = json.loads(done.stdout)["refusals"]
    assert refusal["code"] == ErrorCode.UNREADABLE_IMAGE
    assert "neutral.roughness.1002.png: not a readable image (its decoder crashed (SIGSEGV))" in refusal["words"]
    assert done.stderr == ""


@pytest.fixture
def scans(kept, tmp_path):
    return shutil.copytree(kept / "scans", tmp_path / "scans")


def test_what_is_ordinary_is_well(kept):
    for name in ("scans", "pack.facezip", "gltf", "unity", "godot"):
        code, document = doctor(kept / name)
        assert (code, document["refusals"], document["notes"]) == (ExitCode.DONE, [], [])
        assert document["format"] == "facezip-doctor/1"


def test_every_file_of_a_character_has_a_row(kept):
    _, document = doctor(kept / "scans")
    assert {row["file"] for row in document["rows"]} == {path.name for path in (kept / "scans").iterdir()}
    (row,) = (row for row in document["rows"] if row["file"] == "expr_1.roughness.1002.png")
    assert (row["what"], row["whose"], row["tile"], row["size"]) == ("roughness", "expr_1", 1002, "16x32")
    assert row["encoding"] == "png, uint8, Y, numbers"


def test_every_file_of_a_pack_and_of_an_export_has_a_row(kept):
    for name, own in (("pack.facezip", "manifest.json"), ("unity", "facezip.json")):
        _, document = doctor(kept / name)
        files = {path.relative_to(kept / name).as_posix() for path in (kept / name).rglob("*") if path.is_file()}
        assert {row["file"] for row in document["rows"]} == files - {own}


FAULTS = {
    "expr_0.1001.png": lambda path: path.write_bytes(b"no image"),
    "expr_1.roughness.1002.png": lambda path: path.unlink(),
    "expr_2.obj": lambda path: path.write_text("v 1 2\n"),
    "expr_0.roughness.1001.png": lambda path: path.rename(path.with_suffix(".psd")),
    "expr_1.1002.png": lambda path: write_texture(path, np.arange(48, dtype=np.uint8).reshape(4, 4, 3)),
    "expr_2.1001.png": lambda path: path.with_name("typo.png").write_bytes(path.read_bytes()),
}
NAMED = {"expr_0.roughness.1001.png": "expr_0.roughness.1001.psd", "expr_2.1001.png": "typo.png"}


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sets(st.sampled_from([*FAULTS]), min_size=1))
def test_all_that_is_wrong_is_said_at_once(kept, tmp_path_factory, wrong):
    folder = shutil.copytree(kept / "scans", tmp_path_factory.mktemp("wrong") / "scans")
    for name in wrong:
        FAULTS[name](folder / name)
    code, document = doctor(folder)
    assert code == ExitCode.BAD_INPUT
    said = [refusal["words"] for refusal in document["refusals"]]
    for name in wrong:
        assert sum(f"{NAMED.get(name, name)}: " in words for words in said) == 1, (name, said)


def test_what_is_to_be_decided_has_an_exit_code(scans):
    shutil.copy(scans / "neutral.1001.png", scans / "face_mask.png")
    code, document = doctor(scans)
    assert code == ExitCode.DIFFERENCE
    assert [note["file"] for note in document["notes"] if note["asks"]] == ["face_mask.png"]


def test_what_is_wrong_elsewhere_hides_no_notes(scans):
    shutil.copy(scans / "neutral.1001.png", scans / "face_mask.png")
    (scans / "expr_0.obj").write_text("nothing")
    code, document = doctor(scans)
    assert code == ExitCode.BAD_INPUT
    assert [note["file"] for note in document["notes"]] == ["face_mask.png"]


def test_one_file_is_a_character_too(tmp_path):
    save_character(random_character(expressions=2), tmp_path / "head.glb")
    code, document = doctor(tmp_path / "head.glb")
    assert code == ExitCode.DONE
    assert {row["whose"] for row in document["rows"] if row["what"] == "albedo"} == {"neutral", "expr_0", "expr_1"}


def test_a_folder_with_one_file_is_that_file(tmp_path):
    (tmp_path / "head").mkdir()
    save_character(random_character(expressions=2), tmp_path / "head" / "head.glb")
    code, document = doctor(tmp_path / "head")
    assert code == ExitCode.DONE
    assert document["rows"] == doctor(tmp_path / "head" / "head.glb")[1]["rows"]


def test_what_character_toml_may_not_say_hides_nothing_else(scans):
    (scans / "character.toml").write_text('up = "w"\npart = 1\n')
    (scans / "expr_0.obj").write_text("nothing")
    code, document = doctor(scans)
    assert code == ExitCode.BAD_INPUT
    said = " ".join(refusal["words"] for refusal in document["refusals"])
    assert all(words in said for words in ("up is one of", "part is the name", "expr_0.obj: "))


def test_every_changed_file_of_a_pack_is_named(kept, tmp_path):
    pack = shutil.copytree(kept / "pack.facezip", tmp_path / "pack.facezip")
    changed = sorted(pack.glob("*.difference_0.png"))[:3]
    for path in changed:
        path.write_bytes(path.read_bytes() + b" ")
    (pack / "notes.txt").touch()
    code, document = doctor(pack)
    assert code == ExitCode.BAD_INPUT
    said = " ".join(refusal["words"] for refusal in document["refusals"])
    assert all(name in said for name in [*(path.name for path in changed), "notes.txt"])


def test_a_link_in_a_pack_is_no_file_of_it(kept, tmp_path):
    pack = shutil.copytree(kept / "pack.facezip", tmp_path / "pack.facezip")
    first = min(pack.glob("*.difference_0.png"))
    first.rename(tmp_path / first.name)
    first.symlink_to(tmp_path / first.name)
    code, document = doctor(pack)
    assert code == ExitCode.BAD_INPUT
    (refusal,) = document["refusals"]
    assert f"'{first.name}' is a link or folder, not a file" in refusal["words"]


@pytest.fixture
def export(kept, tmp_path):
    return lambda target: shutil.copytree(kept / target, tmp_path / target)


def notes(folder):
    code, document = doctor(folder)
    return code, {note["file"]: note for note in document["notes"]}


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(["gltf", "unity", "godot"]), st.integers(0, 9), st.integers(1, 255), st.integers(0, 10**6))
def test_a_texture_saved_again_is_well_as_long_as_no_number_changes(kept, tmp_path_factory, target, level, by, place):
    folder = shutil.copytree(kept / target, tmp_path_factory.mktemp("again") / target)
    path = folder / "1002" / "neutral.png"
    before, texels = path.read_bytes(), read_texture(path)
    write_texture(path, texels, compression=level)
    code, said = notes(folder)
    assert code == ExitCode.DONE
    assert [*said] == (["1002/neutral.png"] if path.read_bytes() != before else [])
    texels.reshape(-1)[place % texels.size] ^= by
    write_texture(path, texels)
    code, said = notes(folder)
    assert code == ExitCode.DIFFERENCE
    assert said["1002/neutral.png"]["asks"]


@pytest.mark.parametrize("target", ["gltf", "unity", "godot"])
def test_a_renamed_file_is_found_and_a_missing_one_is_missed(export, target):
    folder = export(target)
    (folder / "1001" / "neutral.png").rename(folder / "1001" / "albedo.png")
    (folder / "1002" / "weights_0.png").unlink()
    code, document = doctor(folder)
    assert code == ExitCode.BAD_INPUT
    renamed, missing = (refusal["words"] for refusal in document["refusals"])
    assert "1001/neutral.png: is called 1001/albedo.png now" in renamed
    assert "1002/weights_0.png: is missing" in missing


META = "fileFormatVersion: 2\nguid: 0123\nTextureImporter:\n  mipmaps:\n    mipMapMode: 0\n    enableMipMap: {mips}\n"
META += "    sRGBTexture: {srgb}\n  nPOTScale: {scale}\n  alphaIsTransparency: {alpha}\n"


@given(srgb=st.booleans(), mips=st.booleans(), scale=st.booleans(), alpha=st.booleans())
@settings(max_examples=16, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_settings_of_unity_are_those_that_the_blend_expects(kept, tmp_path_factory, srgb, mips, scale, alpha):
    folder = shutil.copytree(kept / "unity", tmp_path_factory.mktemp("unity") / "unity", dirs_exist_ok=True)
    text = META.format(srgb=int(srgb), mips=int(mips), scale=int(scale), alpha=int(alpha))
    (folder / "1001" / "neutral.png.meta").write_text(text)
    (folder / "FaceZipHead.cs.meta").write_text("fileFormatVersion: 2\n")
    code, document = doctor(folder)
    said = [note["words"].split()[0] for note in document["notes"] if note["file"] == "1001/neutral.png.meta"]
    wrong = {"sRGBTexture": srgb, "enableMipMap": not mips, "nPOTScale": scale, "alphaIsTransparency": alpha}
    assert sorted(said) == sorted(name for name, holds in wrong.items() if holds)
    assert code == (ExitCode.DIFFERENCE if said else ExitCode.DONE)


@pytest.mark.parametrize(
    ("file", "setting"),
    [("weights_0", "textureCompression: 1"), ("weights_0", "maxTextureSize: 2"), ("neutral", "maxTextureSize: 16")],
)
def test_weights_are_not_compressed_and_nothing_is_made_smaller(export, file, setting):
    folder = export("unity")
    text = f"TextureImporter:\n  {setting}\n  platformSettings:\n  - maxTextureSize: 8192\n    textureCompression: 0\n"
    (folder / "1001" / f"{file}.png.meta").write_text(text)
    code, said = notes(folder)
    assert code == ExitCode.DIFFERENCE
    assert said[f"1001/{file}.png.meta"]["words"].startswith(setting.split(":")[0])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("compress/mode=0", "compress/mode=2"),
        ("process/premult_alpha=false", "process/premult_alpha=true"),
        ("mipmaps/generate=true\n", ""),
        ("[params]\n", "[params]\n\nflags/srgb=1\n"),
        ("[params]\n", "[params]\n\nprocess/hdr_as_srgb=true\n"),
    ],
)
def test_settings_of_godot_are_those_that_were_exported(export, old, new):
    folder = export("godot")
    path = folder / "1001" / "neutral.png.import"
    text = path.read_text()
    # What its editor adds is well.
    path.write_text(text.replace("[remap]\n", '[remap]\n\nuid="uid://abc"\npath="res://.godot/imported/x.ctex"\n'))
    assert doctor(folder)[0] == ExitCode.DONE
    assert old in text
    path.write_text(text.replace(old, new))
    code, said = notes(folder)
    assert code == ExitCode.DIFFERENCE
    assert [*said] == ["1001/neutral.png.import"]


@pytest.mark.parametrize("target", ["unity", "three"])
def test_masks_of_regions_and_lower_bits_are_numbers_like_others(tmp_path, monkeypatch, target):
    (tmp_path / "bundle" / "three").mkdir(parents=True)
    monkeypatch.setattr("facezip.viewer.page.BUNDLE", tmp_path / "bundle")
    model = random_model(meshes=True)
    parts = {key: replace(part, bits=16) for key, part in model.parts.items()}
    write_pack(replace(model, parts=parts), tmp_path / "pack.facezip")
    folder = tmp_path / target
    document = TARGETS[target](tmp_path / "pack.facezip", folder, region=regions_in(tmp_path))
    images = {path.name for path in folder.glob("*.png")}
    assert {"regions.png", *({"neutral_low.png"} if target == "three" else ())} < images
    assert {name for name, entry in document.files.items() if entry.numbers} == images
    again = read_texture(folder / "regions.png")
    write_texture(folder / "regions.png", again, compression=0)
    (folder / "regions.png.meta").write_text(META.format(srgb=1, mips=0, scale=0, alpha=0))
    code, said = notes(folder)
    assert code == ExitCode.DIFFERENCE
    assert not said["regions.png"]["asks"]
    assert said["regions.png.meta"]["words"].startswith("sRGBTexture")


def test_numbers_that_were_changed_in_the_record_itself_are_found(export):
    folder = export("gltf")
    document = json.loads((folder / "facezip.json").read_text())
    document["tiles"]["1001"]["textures"]["difference_0"]["scale"][0] *= 2
    (folder / "facezip.json").write_text(json.dumps(document))
    code, said = notes(folder)
    assert (code, [*said]) == (ExitCode.DIFFERENCE, ["facezip.json"])


@pytest.mark.parametrize("files", [None, {}, {"../x": {"bytes": 1, "sha256": ""}}, {"x": 3}, {"x": {"srgb": False}}])
def test_an_export_without_a_sound_record_is_told_to_be_made_again(export, files):
    folder = export("gltf")
    document = json.loads((folder / "facezip.json").read_text())
    del document["files"]
    (folder / "facezip.json").write_text(json.dumps(document | ({} if files is None else {"files": files})))
    code, said = notes(folder)
    assert code == ExitCode.DIFFERENCE
    assert "export it again" in said["facezip.json"]["words"]


def test_the_record_of_an_export_holds_after_it_was_read_as_json(kept):
    path = kept / "unity" / "facezip.json"
    content = json.loads(path.read_text())
    assert content["sha256"] == checksum(content)
    document = read_document(path, TilesDocument)
    assert with_record(replace(document, files={}, sha256=""), path.parent) == document


def test_the_page_of_the_viewer_is_whole_in_itself(tmp_path):
    (tmp_path / "index.html").write_bytes(b"<!doctype html>\n<!-- FaceZip viewer --><p>")
    assert doctor(tmp_path)[1]["kind"] == doctor(tmp_path / "index.html")[1]["kind"] == "export"


def test_a_name_in_another_unicode_form_is_one_name_from_the_scans_to_the_blend(tmp_path):
    from facezip.character.loading import load_character
    from facezip.pack.read import read_pack

    composed, decomposed = "l\u00e4cheln", "la\u0308cheln"
    save_character(replace(random_character(expressions=2), expressions=(decomposed, "wink")), tmp_path / "scans")
    scans = load_character(tmp_path / "scans")
    assert scans.expressions == (composed, "wink")
    np.testing.assert_array_equal(scans.texture(composed), scans.texture(decomposed))
    write_pack(compress(replace(scans, expressions=(decomposed, "wink")), "pca", differences=2), tmp_path / "p.facezip")
    model = read_pack(tmp_path / "p.facezip")
    assert model.expressions == (composed, "wink")
    np.testing.assert_array_equal(model.blend({composed: 1.0}), model.blend({decomposed: 1.0}))
