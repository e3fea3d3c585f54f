"""What a figure depends on, as one short digest: a figure whose inputs are the same needs no new measurement."""

import ast
from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from reports.site import ROOT

# The rooms that compressing goes through, and the embedded character's.
COMPRESSING = (
    "facezip/errors.py", "facezip/machine", "facezip/files", "facezip/character", "facezip/fit", "facezip/pack",
    "facezip/commands/compress.py",
)  # fmt: skip
EMBEDDED = ("scenes",)
# What benchmarks and exports go through.
ANYTHING = ("facezip", "scenes", "reports/paper", "reports/cleaning.py")
LIBRARIES = ("facezip", "numpy", "numba", "scipy", "scikit-learn")
DIGITS = 12


def versions() -> str:
    """Of everything that figures depend on."""
    return ", ".join(f"{name} {version(name)}" for name in LIBRARIES)


def digest(code: Iterable[str], scans: Path | None, *words: object) -> str:
    """Of the code and the models in some files and folders of the project, a folder of scans, words and versions."""
    found = sha256(repr((versions(), words)).encode())
    for place in code:
        where = ROOT / place
        for file in sorted(where.rglob("*.py")) if where.is_dir() else [where]:
            found.update(_code_in(file))
        for file in sorted(where.rglob("*.npz")):
            found.update(sha256(file.read_bytes()).digest())
    for file in sorted(path for path in scans.rglob("*") if path.is_file()) if scans else []:
        found.update(file.name.encode() + sha256(file.read_bytes()).digest())
    return found.hexdigest()[:DIGITS]


@cache
def _code_in(file: Path) -> bytes:
    """The name and the code of a module, which stays as it is while it runs."""
    return f"{file.relative_to(ROOT)}\n{code_of(file.read_text(encoding='utf-8'))}".encode()


def code_of(source: str) -> str:
    """Python without comments and docstrings, which change no figure."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and ast.get_docstring(
            node, clean=False
        ):
            node.body = node.body[1:] or [ast.Pass()]
    return ast.unparse(tree)
