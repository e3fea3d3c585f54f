"""What the server gives away, to whom, and under which policy."""

import http.client
import json

import pytest

from facezip import FaceZipError
from facezip.viewer.scene import read_scene
from facezip.viewer.server import files_of, serve
from tests.serving import running


@pytest.fixture(scope="module")
def server(pack, bundle):
    with running(serve(files_of(read_scene(pack)))) as server:
        yield server


def ask(server, path, method="GET", host=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    connection.request(method, path, headers={} if host is None else {"Host": host})
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer, content


def test_it_is_bound_to_this_machine_alone(server):
    assert server.server_address[0] == "127.0.0.1"


def test_it_serves_the_page_the_bundle_and_the_scene(server):
    assert ask(server, "/")[1].startswith(b"<!doctype html>")
    assert ask(server, "/viewer.js")[1] == b"'use strict';"
    assert json.loads(ask(server, "/scene.json")[1])["expressions"] == ["expr_0", "expr_1", "expr_2"]
    answer, content = ask(server, "/tile_0.map_0.neutral.png")
    assert (answer.status, answer.getheader("Content-Type"), content[1:4]) == (200, "image/png", b"PNG")


@pytest.mark.parametrize(
    "path",
    [
        "/manifest.json",
        "/albedo.1001.neutral.png",
        "/../manifest.json",
        "//etc/passwd",
        "/%2e%2e/x",
        "/?a",
        "/viewer.js/",
    ],
)
def test_it_serves_nothing_else(server, path):
    assert ask(server, path)[0].status == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_it_can_only_be_read(server, method):
    assert ask(server, "/", method)[0].status == 501


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "localhost:1", "127.0.0.1:{port}.x", ""]
)
def test_any_other_host_is_refused(server, host):
    answer, content = ask(server, "/scene.json", host=host.format(port=server.server_port))
    assert answer.status == 421
    assert b"expr_0" not in content


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}"])
def test_its_own_names_are_answered(server, host):
    assert ask(server, "/", host=host.format(port=server.server_port))[0].status == 200


@pytest.mark.parametrize("path", ["/", "/scene.json", "/nothing"])
def test_every_answer_has_the_policy(server, path):
    answer, _ = ask(server, path)
    policy = answer.getheader("Content-Security-Policy")
    assert "default-src 'none'; script-src 'self';" in policy
    assert "unsafe" not in policy
    assert answer.getheader("X-Content-Type-Options") == "nosniff"
    assert answer.getheader("Cross-Origin-Resource-Policy") == "same-origin"


def test_head_gives_the_length_alone(server):
    answer, content = ask(server, "/", "HEAD")
    assert (answer.status, content) == (200, b"")
    assert int(answer.getheader("Content-Length")) == len(ask(server, "/")[1])


def test_a_port_that_is_taken_is_one_line(server):
    with pytest.raises(FaceZipError, match=f"--port {server.server_port}: .*choose another"):
        serve({}, server.server_port)


def test_a_missing_bundle_says_the_command_that_builds_it(pack, tmp_path, monkeypatch):
    monkeypatch.setattr("facezip.viewer.page.BUNDLE", tmp_path)
    with pytest.raises(FaceZipError, match=r"not built; run 'python -m facezip\.viewer\.build'"):
        files_of(read_scene(pack))
