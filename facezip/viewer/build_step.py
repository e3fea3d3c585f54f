"""The viewer's bundle as a step of setuptools, so that ``pip install`` and the wheel have it."""

import subprocess
import sys
from pathlib import Path

from setuptools.command.build_py import build_py


class BuildWithViewer(build_py):  # type: ignore[misc]
    """Builds the bundle before the package's files are gathered; where npm is missing, goes on without it."""

    def run(self) -> None:
        """Called by setuptools; ``facezip view`` itself says what to do where the bundle is missing."""
        script = Path(__file__).with_name("build.py")
        done = subprocess.run(
            [sys.executable, str(script)], capture_output=True, text=True, errors="replace", check=False
        )
        self.announce((done.stdout + done.stderr).strip(), level=3 if done.returncode else 2)
        super().run()
