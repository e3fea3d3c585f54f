"""Golden packs, one of every version of the format, are read for ever, and to the same textures."""

from pathlib import Path

import numpy as np
import pytest

from facezip import read_pack, verify_pack, write_pack
from facezip.manifest import FORMAT
from facezip.textures import read_texture

GOLDEN = sorted((Path(__file__).parent.parent / "data").glob("pack-*/golden.facezip"))


def test_the_current_version_has_a_golden_pack():
    assert FORMAT.split("/")[1] in [pack.parent.name.removeprefix("pack-") for pack in GOLDEN]


@pytest.mark.parametrize("pack", GOLDEN, ids=lambda pack: pack.parent.name)
def test_a_golden_pack_reads_as_on_its_first_day(pack):
    model = read_pack(pack)
    assert sorted(model.expressions) == sorted(file.stem for file in pack.parent.glob("*.png"))
    for name in model.expressions:
        day_one = read_texture(pack.parent / f"{name}.png")
        assert np.abs(np.rint(255 * model.reconstruct(name)) - day_one).max() <= 1
    assert len(model.meshes.deltas) == len(model.expressions)


def test_writing_what_was_read_gives_the_same_bytes(tmp_path):
    pack = GOLDEN[-1]
    manifest = verify_pack(pack)
    write_pack(read_pack(pack), tmp_path / "again", name=manifest.name, made_with=manifest.made_with)
    again = verify_pack(tmp_path / "again")
    assert again.files["neutral.png"] == manifest.files["neutral.png"]
    assert again.files["deltas.f32"] == manifest.files["deltas.f32"]
