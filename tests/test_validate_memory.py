"""``facezip validate --memory``: the same report, in less memory."""

import json
import shutil

import pytest
from click.testing import CliRunner

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.methods import compress
from facezip.machine import memory
from facezip.pack.write import write_pack
from render.budget import check_budget
from render.settings import Settings
from tests.facezip.rigging.case import repeated
from tests.facezip.surfaces import random_surface
from tests.peaks import peak_of

LOOK = ("--views", 1, "--lights", 1, "--resolution", 64, "--spp", 4, "--max-spp", 4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Scans with albedo, normals and roughness on two tiles, and a pack of them."""
    folder = tmp_path_factory.mktemp("validate")
    scans = random_surface(expressions=3, tiles=(2, 1))
    save_character(scans, folder / "scans")
    write_pack(compress(scans, "pca", differences=1), folder / "me.facezip")
    return folder


def validate(folder, output, *options):
    call = ("validate", folder / "scans", folder / "me.facezip", "-o", output, *LOOK, "--json", *options)
    result = CliRunner().invoke(facezip, [*map(str, call)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def without_times(document):
    return {key: value for key, value in document.items() if key not in ("seconds", "pairs_per_second")}


def test_within_a_limit_the_report_is_the_same(folder, tmp_path, monkeypatch):
    here = validate(folder, tmp_path / "here")
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed = validate(folder, tmp_path / "streamed")
    assert without_times(streamed) == without_times(here)
    for file in (tmp_path / "here" / "renders").glob("*.exr"):
        assert file.read_bytes() == (tmp_path / "streamed" / "renders" / file.name).read_bytes()


def test_workers_have_the_limit_too(folder, tmp_path):
    call = ("validate", folder / "scans", folder / "me.facezip", "-o", tmp_path / "x", *LOOK, "--workers", 1)
    result = CliRunner().invoke(facezip, [*map(str, call), "--memory", "410M"])
    assert isinstance(result.exception, FaceZipError)
    assert "--memory 410M" in str(result.exception)
    assert validate(folder, tmp_path / "y", "--workers", 1, "--memory", "1G")["rendered"] == 4


def test_what_the_renderer_holds_is_refused_where_it_has_no_room(tmp_path):
    """More skins, samples or texels need more."""
    small = random_surface(expressions=2)
    least = []
    for scans, skins, look in (
        (small, 2, Settings(resolution=64)),
        (small, 3, Settings(resolution=64)),
        (small, 2, Settings(resolution=512)),
        (repeated(small, 4), 2, Settings(resolution=64)),
    ):
        with memory.limited(1, tmp_path), pytest.raises(FaceZipError, match=r"need \d+M at least") as refusal:
            check_budget(scans, skins, look)
        assert refusal.value.code is ErrorCode.BAD_VALUE
        least.append(int(str(refusal.value).split("need ")[1].split("M")[0]))
    assert least[0] < min(least[1:])


def test_a_limit_is_kept_where_a_run_without_it_takes_more(tmp_path):
    """Two processes with large maps: memory shows in nothing less."""
    scans = repeated(random_surface(expressions=6), 16)
    save_character(scans, tmp_path / "scans")
    write_pack(compress(scans, "pca", differences=4), tmp_path / "me.facezip")
    call = ("validate", tmp_path / "scans", tmp_path / "me.facezip", *LOOK, "-o")
    in_memory, whole = peak_of(*call, tmp_path / "whole")
    shutil.rmtree(tmp_path / "whole")
    streamed, same = peak_of(*call, tmp_path / "streamed", "--memory", "660M")
    assert streamed < 660e6 < in_memory
    assert without_times(same) == without_times(whole)
