"""A pack that another program replaces while it is exported: what is written is of one pack, never of both."""

import shutil

import pytest

from facezip.export import TARGETS, source
from facezip.files.renaming import exchange
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import files_of


@pytest.fixture(params=["weight maps", "masks"])
def packs(request, tmp_path):
    """Two that differ in nothing but numbers."""
    for seed, name in enumerate(("me", "other")):
        model = random_model(seed, meshes=True)
        write_pack(model if request.param == "weight maps" else masked(model), tmp_path / f"{name}.facezip")
    return tmp_path / "me.facezip", tmp_path / "other.facezip"


def exported(pack, folder):
    TARGETS["gltf"](pack, folder)
    return files_of(folder)


def test_of_a_pack_that_is_replaced_while_it_is_read_the_last_is_exported(packs, tmp_path, monkeypatch):
    pack, other = packs
    last = exported(shutil.copytree(other, tmp_path / "last" / pack.name), tmp_path / "alone")
    read, times = source.read_stored, []

    def replaced(folder, manifest):
        found = read(folder, manifest)
        if not times:
            assert exchange(pack, other)
        times.append(1)
        return found

    monkeypatch.setattr(source, "read_stored", replaced)
    assert exported(pack, tmp_path / "out") == last
    assert len(times) == 2


def test_what_becomes_of_a_pack_once_it_is_read_changes_nothing(packs, tmp_path, monkeypatch):
    pack, other = packs
    first = exported(pack, tmp_path / "alone")
    write = source.Source.folder_of

    def replaced(*given):
        if other.exists():
            shutil.rmtree(pack)
            other.rename(pack)
        return write(*given)

    monkeypatch.setattr(source.Source, "folder_of", replaced)
    assert exported(pack, tmp_path / "out") == first
    assert not other.exists()
