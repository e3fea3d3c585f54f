"""A pack in the form that a target takes: one module a target."""

from collections.abc import Callable
from typing import Any

from facezip.export.web import export_web

# Each is called with the pack and the output, and with those options as keywords that were given.
TARGETS: dict[str, Callable[..., dict[str, Any]]] = {"web": export_web}
