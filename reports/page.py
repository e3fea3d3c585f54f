"""A template and its data become one HTML file that opens from disk: no network, nothing beside it."""

import base64
import hashlib
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from facezip.files.writing import write_whole

_SCRIPT = "page.js"
_STYLE = "style.css"


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render_page(template: str, **context: Any) -> str:
    """The HTML of a template that extends ``base.html``.

    Every value is escaped. A content security policy allows the page's own script alone (by its hash) and images from
    data URIs, so that not even a slip in a template lets a name run code or reach a network.
    """
    environment = _environment()
    script, style = (_source(environment, name) for name in (_SCRIPT, _STYLE))
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return environment.get_template(template).render(
        script=Markup(script), style=Markup(style), script_hash=digest, **context
    )


def write_page(path: Path, template: str, **context: Any) -> Path:
    """Render into ``path``, whole or not at all; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
    write_whole(path, render_page(template, **context).encode(errors="backslashreplace"))
    return path


def _source(environment: Environment, name: str) -> str:
    if environment.loader is None:
        raise RuntimeError("the report environment has no templates")
    return environment.loader.get_source(environment, name)[0]
