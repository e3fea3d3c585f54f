"""What tests of several rooms use: Node.js, with the packages that judge exports, and a browser."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import settings

# No law is of wall-clock time, and other work may share the machine.
settings.register_profile("facezip", deadline=None)
settings.load_profile("facezip")

# For the tests of the pytest plugin.
pytest_plugins = ["pytester"]
NODE = Path(__file__).parent / "node"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-sync", "--disable-background-networking", "--disable-component-update",
    "--no-first-run", "--force-color-profile=srgb",
]  # fmt: skip


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


@pytest.fixture(scope="session")
def chromium():
    """Headless Chromium, whose WebGL is drawn in software."""
    driver = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    with driver.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()
