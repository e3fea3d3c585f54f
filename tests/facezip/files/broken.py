"""Decoders that really crash, hang and take all memory, in every process that is started.

An image ends its decoder where its bytes end with one of the words of ``WAYS``: behind what a reader of PNG needs.
"""

import ctypes
import os
import resource
import time
from pathlib import Path

ROOT = Path(__file__).parents[3]
# Python imports a module of this name when it starts.
STARTED = "sitecustomize.py"
PROGRAM = "from tests.facezip.files import broken\nbroken.break_decoders()\n"


def crash():
    ctypes.string_at(0)


def hang():
    while True:
        time.sleep(0.1)


def explode():
    """Take memory until there is none, and end as C++ does where nobody catches that."""
    malloc = ctypes.CDLL(None).malloc
    malloc.restype, malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    while malloc(2**26):
        pass
    os.abort()


WAYS = {b"crash": crash, b"hangs": hang, b"grows": explode}


def surroundings(folder):
    """The environment of processes whose decoders are broken."""
    (folder / STARTED).write_text(PROGRAM, encoding="utf-8")
    return {"PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}


def break_decoders():
    import OpenImageIO as oiio

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    ordinary = oiio.ImageInput.open

    def opened(name, config):
        WAYS.get(Path(name).read_bytes()[-5:], int)()
        return ordinary(name, config)

    oiio.ImageInput.open = opened


def mark(path, way):
    """Let an image end its decoder."""
    path.write_bytes(path.read_bytes() + way)


def sums(files):
    """The sum of every image, or why there is none."""
    return {file.name: _sum(file) for file in files}


def _sum(file):
    from facezip.errors import FaceZipError
    from facezip.files.images import read_texture

    try:
        return int(read_texture(file).sum())
    except FaceZipError as error:
        return str(error)


def end_at(file, number):
    """End the process by a signal while it is at an image."""
    from facezip.files.opening import opened

    with opened(file):
        os.kill(os.getpid(), number)
