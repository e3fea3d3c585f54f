"""``facezip view`` and ``facezip export --to web`` as their users call them."""

import http.client
import json
import shutil
import signal
import subprocess
import sys

import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.pack.write import write_pack
from facezip.viewer.build import BUNDLE
from tests.facezip.conftest import random_character, random_model
from tests.test_cli import run


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("view") / "random.facezip"
    write_pack(random_model(meshes=True), path)
    return path


@pytest.mark.skipif(not BUNDLE.is_dir(), reason="the viewer is not built; run 'make viewer'")
def test_view_serves_until_interrupted_and_ends_cleanly(pack):
    call = [sys.executable, "-c", "from facezip.cli import main; main()", "view", str(pack), "--no-browser", "--json"]
    # A shell may have started these tests with interrupts ignored, which a child would inherit.
    process = subprocess.Popen(
        call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    document = json.loads(process.stdout.readline())
    host = document["url"].removeprefix("http://").strip("/")
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.request("GET", "/scene.json")
    assert json.loads(connection.getresponse().read())["name"] == "random"
    connection.close()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == ExitCode.DONE
    assert (out, err.strip()) == ("", "")


def test_a_pack_that_fails_verification_is_refused_with_the_same_line(pack, tmp_path):
    spoilt = tmp_path / "spoilt.facezip"
    shutil.copytree(pack, spoilt)
    content = bytearray((spoilt / "difference_2.png").read_bytes())
    content[len(content) // 2] ^= 1
    (spoilt / "difference_2.png").write_bytes(content)
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
    assert "not of sheet" in done.stderr
    assert len(done.stderr.splitlines()) == 1
