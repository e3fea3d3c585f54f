"""Golden packs, one of every version of the format, are read for ever, and to the same textures."""

from pathlib import Path

import numpy as np
import pytest

from facezip.character.folder import file_name
from facezip.character.neutrals import packed_neutral
from facezip.files.images import read_texture_exactly
from facezip.pack.manifest import HEAD_FILE
from facezip.pack.parsing import VERSIONS
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack

GOLDEN = sorted((Path(__file__).parents[2] / "data").glob("pack-*/golden.facezip"))


@pytest.mark.parametrize("version", [*VERSIONS])
def test_every_version_has_a_golden_pack(version):
    assert version.split("/")[1] in [pack.parent.name.removeprefix("pack-") for pack in GOLDEN]


@pytest.mark.parametrize("pack", GOLDEN, ids=lambda pack: pack.parent.name)
def test_a_golden_pack_reads_as_on_its_first_day(pack):
    model, seen = read_pack(pack), set()
    for name in model.expressions:
        for kind in model.maps:
            for tile in model.tiles:
                stem = file_name(name, kind, tile, model.tiles)
                day_one = read_texture_exactly(pack.parent / f"{stem}.png").astype(int)
                today = packed_neutral(model.texels({name: 1.0}, (kind.name, tile)), kind, 8)
                assert np.abs(today - day_one).max() <= 1
                seen.add(stem)
    assert seen == {file.stem for file in pack.parent.glob("*.png")}
    assert len(model.meshes.vertices) == len(model.expressions)


@pytest.mark.parametrize("pack", GOLDEN, ids=lambda pack: pack.parent.name)
def test_what_was_read_of_any_version_is_written_as_the_newest_with_the_same_texels(tmp_path, pack):
    """Ranges are stretched anew, so that only neutrals and weights keep every byte; of normals, x and y count."""
    manifest = verify_pack(pack)
    write_pack(read_pack(pack), tmp_path / "again", name=manifest.name, made_with=manifest.made_with)
    again = verify_pack(tmp_path / "again")
    assert again.geometry.files == (HEAD_FILE,)
    for key, (entry, texture) in manifest.entries().items():
        new = again.entries()[key][1].neutral
        old_texels, new_texels = (
            read_texture_exactly(file)[..., : 2 if entry.kind.is_normal else 4]
            for file in (pack / texture.neutral, tmp_path / "again" / new)
        )
        np.testing.assert_array_equal(new_texels, old_texels)
    assert again.masks == manifest.masks
    if manifest.masks:
        assert again.files[manifest.masks.activations] == manifest.files[manifest.masks.activations]
        for tile, masks in read_pack(pack).masked.masks.items():
            np.testing.assert_array_equal(read_pack(tmp_path / "again").masked.masks[tile], masks)
    for old, new in zip(manifest.tiles, again.tiles, strict=True):
        for before, after in zip(old.weights, new.weights, strict=True):
            np.testing.assert_array_equal(
                read_texture_exactly(tmp_path / "again" / after), read_texture_exactly(pack / before)
            )
