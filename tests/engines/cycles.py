"""Blender as a Python package of its own environment: what ``make engines`` installs runs ``blender/session.py``."""

import json
import os
import subprocess
from pathlib import Path

import OpenImageIO as oiio
import pytest

ROOT = Path(__file__).parents[2]
PYTHON = Path(os.environ.get("FACEZIP_BLENDER_PYTHON", ROOT / ".venv-engines" / "bin" / "python"))
SESSION = Path(__file__).parent / "blender" / "session.py"


def blender():
    """The Python that has ``bpy``, or the test skips."""
    if not PYTHON.is_file():
        pytest.skip("Blender is not installed: make engines")
    return PYTHON


def run(python, folder, cases, timeout=280):
    """The answers of ``session.py`` to cases."""
    request = folder / "request.json"
    request.write_text(json.dumps({"cases": cases}), encoding="utf-8")
    done = subprocess.run(
        [str(python), str(SESSION), str(request)], capture_output=True, text=True, check=False, timeout=timeout
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    return json.loads((folder / "answers.json").read_text(encoding="utf-8"))


def picture(file):
    """Linear floats ``(H, W, 3)`` of an OpenEXR file."""
    return oiio.ImageBuf(str(file)).get_pixels(oiio.FLOAT)[..., :3]
