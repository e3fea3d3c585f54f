"""Runs a project in a real Godot: the engine's own build for browsers, in headless Chromium."""

import base64
import json
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np

from tests.engines.pck import pck
from tests.serving import running

PROJECT = Path(__file__).parent / "project"
TYPES = {".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm"}
DONE_MS = 240_000
# Pixels a texel and side, of which the middle one is kept: there filters give the texel itself, and no mip-map of it.
ZOOM = 3


@dataclass(frozen=True)
class Shown:
    """What a run gave.

    Attributes
    ----------
    pictures : ``(H, W, 3)`` uint8 by case, view and pose.
    meshes : by case the names of blend shapes, whether there is a skin, and the vertices of every surface.
    errors : what the engine printed as such.
    version : the engine's own.
    """

    pictures: dict[tuple[str, str, str], np.ndarray]
    meshes: dict[str, dict]
    errors: list[str]
    version: str


def run(browser, runtime: Path, files: Mapping[str, bytes], cases: list[dict]) -> Shown:
    """Show ``cases`` in one start of the engine; ``files`` lie in the project by their paths.

    A case may have its own ``zoom``, and a ``portrait`` of :mod:`tests.engines.pictures` instead of texels laid flat.
    """
    project = {file.name: file.read_bytes() for file in PROJECT.iterdir() if file.suffix != ".html"}
    asked = [{"zoom": ZOOM} | case for case in cases]
    # The engine asks for the list of classes with names, of which there are none.
    project |= {".godot/global_script_class_cache.cfg": b"list=[]\n", "cases.json": json.dumps(asked).encode()}
    archive = pck({**project, **files})
    served = {f"/{name}": (runtime / name).read_bytes() for name in ("index.js", "index.wasm")}
    served |= {"/index.pck": archive, "/page.html": (PROJECT / "page.html").read_bytes()}
    with serving(served) as address, browser.new_context() as context, context.new_page() as page:
        faults = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(f"{address}/page.html")
        page.locator("body.done, body.failed").wait_for(timeout=DONE_MS, state="attached")
        pictures, meshes, errors, version = page.evaluate("[pictures, meshes, errors, version]")
    of = {case["name"]: case for case in asked}
    texels = {(name, view, pose): _texels(content, of[name]) for name, view, pose, content in pictures}
    return Shown(texels, meshes, [*errors, *faults], version)


def _texels(content: str, case: dict) -> np.ndarray:
    zoom = case["zoom"]
    pixels = np.frombuffer(base64.b64decode(content), np.uint8).reshape(*(side * zoom for side in case["size"]), 3)
    return pixels[zoom // 2 :: zoom, zoom // 2 :: zoom]


@contextmanager
def serving(files: Mapping[str, bytes]):
    """The address of a server of these files, with the headers without which the engine does not start."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            content = files.get(self.path)
            self.send_response(404 if content is None else 200)
            self.send_header("Content-Type", TYPES.get(Path(self.path).suffix, "application/octet-stream"))
            self.send_header("Content-Length", str(len(content or b"")))
            self.send_header("Cross-Origin-Opener-Policy", "same-origin")
            self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
            self.end_headers()
            self.wfile.write(content or b"")

        def log_message(self, *arguments):
            pass

    with running(ThreadingHTTPServer(("127.0.0.1", 0), Handler)) as server:
        yield f"http://127.0.0.1:{server.server_port}"
