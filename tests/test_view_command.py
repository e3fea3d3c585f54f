"""``facezip view`` and ``facezip export --to web`` as their users call them."""

import http.client
import json
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.fit.methods import compress
from facezip.pack.write import write_pack
from facezip.viewer.build import BUNDLE
from tests.facezip.conftest import random_character, random_model
from tests.facezip.surfaces import random_surface
from tests.test_cli import run


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("view") / "random.facezip"
    write_pack(random_model(meshes=True), path)
    return path


built = pytest.mark.skipif(not BUNDLE.is_dir(), reason="the viewer is not built; run 'make viewer'")


@contextmanager
def viewing(*arguments):
    """The process of ``facezip view``, and its document; interrupted at the end of the block if it is not yet."""
    call = [sys.executable, "-c", "from facezip.cli import main; main()", "view", *map(str, arguments)]
    # A shell may have started these tests with interrupts ignored, which a child would inherit.
    process = subprocess.Popen(
        [*call, "--no-browser", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    with process:
        try:
            yield process, json.loads(process.stdout.readline())
        finally:
            process.send_signal(signal.SIGINT)


def asked(document, path):
    connection = http.client.HTTPConnection(document["url"].removeprefix("http://").strip("/"), timeout=30)
    connection.request("GET", path)
    content = connection.getresponse().read()
    connection.close()
    return content


@built
def test_view_serves_until_interrupted_and_ends_cleanly(pack):
    with viewing(pack) as (process, document):
        assert json.loads(asked(document, "/scene.json"))["name"] == "random"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        assert process.returncode == ExitCode.DONE
        assert (out, err.strip()) == ("", "")


@built
def test_view_and_export_take_every_map_on_every_tile(tmp_path):
    character = random_surface(side=32, tiles=(2, 1))
    save_character(character, tmp_path / "scans")
    write_pack(compress(character), tmp_path / "a.facezip")
    with viewing(tmp_path / "a.facezip", tmp_path / "scans") as (_, document):
        scene = json.loads(asked(document, "/scene.json"))
        assert [entry["name"] for entry in scene["maps"]] == ["albedo", "normal", "roughness"]
        assert all(entry["error"] > 0 for entry in scene["maps"])
        assert [tile["number"] for tile in scene["tiles"]] == [1001, 1002]
        assert asked(document, "/tile_1.map_2.original_4.png").startswith(b"\x89PNG")
    page = tmp_path / "page.html"
    options = "--to", "web", "-o", page, "--character", tmp_path / "scans", "--json"
    done = run("export", tmp_path / "a.facezip", *options)
    assert json.loads(done.stdout) == {
        "format": "facezip-export-web/1",
        "output": str(page),
        "bytes": page.stat().st_size,
        "originals": True,
    }


def test_a_pack_that_fails_verification_is_refused_with_the_same_line(pack, tmp_path):
    spoilt = tmp_path / "spoilt.facezip"
    shutil.copytree(pack, spoilt)
    content = bytearray((spoilt / "albedo.1001.difference_2.png").read_bytes())
    content[len(content) // 2] ^= 1
    (spoilt / "albedo.1001.difference_2.png").write_bytes(content)
    calls = [
        run("verify", spoilt),
        run("view", spoilt, "--no-browser"),
        run("export", spoilt, "--to", "web", "-o", tmp_path / "x"),
    ]
    assert [done.returncode for done in calls] == [ExitCode.BAD_INPUT] * 3
    assert len({done.stderr for done in calls}) == 1
    assert len(calls[0].stderr.splitlines()) == 1
    assert not (tmp_path / "x").exists()


def test_view_refuses_the_character_of_another_pack(pack, tmp_path):
    save_character(random_character(), tmp_path / "sheet")
    done = run("view", pack, tmp_path / "sheet", "--no-browser")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "random.facezip: has no expression 'expr_3', which sheet has" in done.stderr
    assert len(done.stderr.splitlines()) == 1
