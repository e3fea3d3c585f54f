"""File names for tests: readable, safe on every file system, and different for different tests."""

import hashlib
import re

_LONGEST = 120


def file_stem(test: str, name: str = "") -> str:
    """The stem of a test's files, from its node id and the name of one of its images.

    ``tests/test_skin.py::test_rig[studio]`` is ``tests.test_skin.test_rig.studio``. Where characters had to go or the
    name is too long, a hash of the whole takes their place; it stands behind capitals too, in which alone two names may
    differ that many file systems take for one.
    """
    path, *parts = test.split("::")
    readable = ".".join([path.removesuffix(".py").replace("/", "."), *parts, *([name] if name else [])])
    readable = re.sub(r"\[(.*)\]", r".\1", readable)
    safe = re.sub(r"[^A-Za-z0-9_.-]+|\.{2,}", "_", readable).strip(".")[:_LONGEST]
    if safe == readable.lower():
        return safe
    return f"{safe}-{hashlib.sha256(f'{test} {name}'.encode()).hexdigest()[:8]}"
