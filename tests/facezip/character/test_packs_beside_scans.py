"""A pack may be written into the folder of its scans: they are read as before."""

import shutil

import pytest

from facezip.batch.finished import digest_of
from facezip.character.examination import examine_character
from facezip.character.loading import load_character, save_character
from facezip.fit.pipeline import Request, compress_into
from facezip.pack.verification import verify_pack
from tests.facezip.conftest import random_character


def as_saved(folder):
    save_character(random_character(), folder)


def textures_below(folder):
    """As other programs call and keep them."""
    as_saved(folder)
    (folder / "textures").mkdir()
    for image in folder.glob("*.png"):
        image.rename(folder / "textures" / f"{image.stem}_BaseColor.png")


def all_below(folder):
    as_saved(folder.parent / "flat")
    for mesh in (folder.parent / "flat").glob("*.obj"):
        (folder / mesh.stem).mkdir(parents=True)
        shutil.move(mesh, folder / mesh.stem / mesh.name)
        shutil.move((folder.parent / "flat" / f"{mesh.stem}.png"), folder / mesh.stem / f"{mesh.stem}.png")


def by_pattern(folder):
    textures_below(folder)
    (folder / "character.toml").write_text('[maps.albedo]\nfiles = "textures/{name}_BaseColor.png"\n')


def as_gltf(folder):
    folder.mkdir()
    save_character(random_character(), folder / "me.glb")


LAYOUTS = (as_saved, textures_below, all_below, by_pattern, as_gltf)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("name", ["me.facezip", "packs/me.facezip"])
def test_scans_are_read_as_before_with_a_pack_beside_them(layout, name, tmp_path):
    scans = tmp_path / "scans"
    layout(scans)
    before = examine_character(scans), load_character(scans).notes, digest_of(scans, {})
    compress_into(scans, scans / name, Request(method="pca"))
    assert (examine_character(scans), load_character(scans).notes, digest_of(scans, {})) == before
    verify_pack(scans / name)
