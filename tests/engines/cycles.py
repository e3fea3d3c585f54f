"""Blender as a Python package in an environment of its own, where the scripts of ``blender`` run: ``make engines``."""

import json
import os
import subprocess
from pathlib import Path

import OpenImageIO as oiio
import pytest

ROOT = Path(__file__).parents[2]
PYTHON = Path(os.environ.get("FACEZIP_BLENDER_PYTHON", ROOT / ".venv-engines" / "bin" / "python"))
SCRIPTS = Path(__file__).parent / "blender"


def needed():
    """Skip the test where there is no Python that has ``bpy``."""
    if not PYTHON.is_file():
        pytest.skip("Blender is not installed: make engines")


def run(script, folder, request, timeout=280):
    """The answers of a script of ``blender`` to a request."""
    file = folder / "request.json"
    file.write_text(json.dumps(request), encoding="utf-8")
    command = [str(PYTHON), str(SCRIPTS / script), str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=timeout)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    return json.loads((folder / "answers.json").read_text(encoding="utf-8"))


def picture(file):
    """Linear floats ``(H, W, 4)`` of an OpenEXR file."""
    return oiio.ImageBuf(str(file)).get_pixels(oiio.FLOAT)
