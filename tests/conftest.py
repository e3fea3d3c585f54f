"""What tests of several rooms use: Node.js, with the packages that judge exports."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

# For the tests of the pytest plugin.
pytest_plugins = ["pytester"]
NODE = Path(__file__).parent / "node"


@pytest.fixture(scope="session")
def node():
    """Runs one of the scripts of ``tests/node`` and reads the JSON that it prints."""
    if shutil.which("node") is None:
        pytest.skip("Node.js is not installed")
    if not (NODE / "node_modules").is_dir():
        pytest.skip("its packages are not installed: npm ci --prefix tests/node")

    def run(script, *arguments):
        command = ["node", str(NODE / script), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture
def encoder(node, monkeypatch):
    """The UASTC encoder can be found."""
    monkeypatch.setenv("NODE_PATH", str(NODE / "node_modules"))
    return os.environ
