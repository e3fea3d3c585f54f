"""What no verb writes: anything into a pack, which any file or folder more would damage."""

import sys
from importlib import import_module

import click
import numpy as np
import pytest

from facezip.character.loading import save_character
from facezip.cli import VERBS, main
from facezip.errors import ExitCode
from facezip.export import TARGETS
from facezip.files.images import write_texture
from facezip.fit.pipeline import Request, compress_into
from facezip.fit.settings import Settings
from facezip.pack.verification import verify_pack
from tests.facezip.conftest import random_character

# What each verb is given besides -o, by the words that call it.
CALLS = {
    "animate": ("SCANS", "PACK"),
    "batch": ("SCANS",),
    "bench scaling": (),
    "check": ("SCANS",),
    "compress": ("SCANS",),
    "decompress": ("PACK",),
    "demo": (),
    "export": ("PACK", "--to", "gltf"),
    "extend": ("PACK", "SCANS"),
    "importance": ("SCANS",),
    "layers": ("PACK",),
    "paper": ("SCANS",),
    "rates": ("SCANS",),
    "rig": ("SCANS", "--template", "SCANS"),
    "validate": ("SCANS", "PACK"),
}
# Others of the same verbs, which write in other ways.
ALSO = {
    "check --register": ("check", "SCANS", "--register", "PACK/inside"),
    "check --register GLB": ("check", "SCANS", "--register", "PACK/inside.glb"),
    "decompress --weights": ("decompress", "PACK", "--weights", "-o", "PACK/inside"),
    "export to a page": ("export", "PACK", "--to", "web", "-o", "PACK/inside.html"),
    "export to a page far down": ("export", "PACK", "--to", "web", "-o", "PACK/a/b"),
    # The layers of MetaHuman, which are written as those of O3DE, take packs of given masks alone.
    **{
        f"export to {target}": ("export", "PACK", "--to", target, "-o", "PACK/inside")
        for target in TARGETS
        if target != "metahuman"
    },
}
WRITTEN = {verb: (*verb.split(), *given, "-o", "PACK/inside") for verb, given in CALLS.items()} | ALSO


def commands():
    """All verbs, with those of groups."""
    for verb in VERBS:
        command = import_module(f"facezip.commands.{verb}").command
        if isinstance(command, click.Group):
            yield from ((f"{verb} {name}", inner) for name, inner in command.commands.items())
        else:
            yield verb, command


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """Scans, the pack of them, and another pack, which nobody reads."""
    folder = tmp_path_factory.mktemp("places")
    save_character(random_character(), folder / "SCANS")
    for name in ("PACK", "OTHER"):
        request = Request(settings=Settings(differences=3, weight_scale=4, nonnegative=True))
        compress_into(folder / "SCANS", folder / name, request)
    return folder


@pytest.fixture
def run(places, monkeypatch, capsys):
    """Calls the command line in this process, in the folder of the places."""

    def call(*arguments):
        monkeypatch.chdir(places)
        monkeypatch.setattr(sys, "argv", ["facezip", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code), *capsys.readouterr()

    return call


def names_in(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_all_verbs_that_write_are_called_here():
    assert {*CALLS} == {name for name, command in commands() if any(each.name == "output" for each in command.params)}


@pytest.mark.parametrize("case", WRITTEN)
def test_no_verb_writes_into_a_pack(case, run, places):
    before = names_in(places)
    code, out, error = run(*WRITTEN[case])
    assert (code, out) == (ExitCode.CANNOT_WRITE, ""), error
    assert error.splitlines()[-1].startswith("facezip: PACK/")
    assert f"lies within the pack {places.resolve() / 'PACK'}, " in error
    assert names_in(places) == before
    verify_pack(places / "PACK")


@pytest.mark.parametrize("place", ["OTHER/inside", "OTHER/a/../b/c", "link/inside", "OTHER/manifest.json"])
def test_no_pack_is_written_into_however_it_is_reached(place, run, places):
    if not (places / "link").exists():
        (places / "link").symlink_to(places / "OTHER")
    before = names_in(places)
    code, _, error = run("decompress", "PACK", "-o", place, "--overwrite")
    assert (code, len(error.splitlines())) == (ExitCode.CANNOT_WRITE, 1)
    assert f"{place}: lies within the pack {places.resolve() / 'OTHER'}, " in error
    assert names_in(places) == before


def test_packs_beside_the_output_and_manifests_of_others_are_in_nobodys_way(run, places, tmp_path):
    (tmp_path / "manifest.json").write_text('{"name": "a page"}')
    write_texture(tmp_path / "icon.png", np.zeros((4, 4, 3), np.uint8))
    for place in (tmp_path / "out", places / "PACK" / ".." / "out"):
        code, _, error = run("decompress", "PACK", "-o", place)
        assert (code, error) == (0, "")
