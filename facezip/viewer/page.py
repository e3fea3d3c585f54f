"""The HTML around the bundle: with everything in it, or with links to what a server has."""

import base64
import hashlib
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from facezip.documents.document import to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.viewer.build import BUNDLE, SOURCES
from facezip.viewer.documents import SceneDocument
from facezip.viewer.scene import Scene

SCRIPT = "viewer.js"
STYLE = "viewer.css"
LICENCES = "LICENCES.txt"
COMMAND = "python -m facezip.viewer.build"


def bundle_file(name: str) -> bytes:
    """One file of the bundle; ``MISSING_FILE`` with the command that makes it where it was not built."""
    path = BUNDLE / name
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: the viewer is not built; run '{COMMAND}' (needs Node.js)")
    return path.read_bytes()


def bundle_folder(name: str) -> Path:
    """A folder of the bundle; as :func:`bundle_file`."""
    path = BUNDLE / name
    if not path.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: the viewer is not built; run '{COMMAND}' (needs Node.js)")
    return path


def served_policy() -> str:
    """The content security policy of the served page: nothing but this server, and no script inside the page."""
    return (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


def served_page() -> bytes:
    """The page that loads its parts from the server that it came from."""
    return _render(policy=None, script=None, style=None, blocks={}).encode()


def single_page(scene: Scene) -> bytes:
    """The page with everything in it: opens from disk, asks for nothing."""
    script, style = (bundle_file(name).decode() for name in (SCRIPT, STYLE))
    policy = (
        f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    blocks: dict[str, str] = {"scene.json": document_json(scene.document)}
    blocks |= {name: base64.b64encode(content()).decode("ascii") for name, content in scene.assets.items()}
    return _render(policy=policy, script=Markup(script), style=Markup(style), blocks=blocks).encode()


def document_json(document: SceneDocument) -> Markup:
    """JSON that can stand inside a script element, whatever the names in it are."""
    text = to_json(document, indent=None)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _render(**context: Any) -> str:
    environment = Environment(loader=FileSystemLoader(SOURCES), autoescape=True, undefined=StrictUndefined)
    licences = Markup(bundle_file(LICENCES).decode().replace("--", "- -")) if context["script"] else ""
    return environment.get_template("page.html").render(licences=licences, **context)


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
