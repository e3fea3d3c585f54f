"""UASTC by Basis Universal, the one block format that every glTF loader turns into what its GPU has.

No kept encoder is on PyPI. The npm package ``ktx2-encoder`` is one; where Node.js and it are installed, they are used.
"""

import os
import shutil
import struct
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from facezip.blocks.codecs import Codec, of_library
from facezip.errors import ErrorCode, FaceZipError

PACKAGE = "ktx2-encoder"
SCRIPT = Path(__file__).with_name("basis.mjs")


@contextmanager
def uastc() -> Iterator[Codec]:
    """A codec that lasts as long as the block: the encoder is a program of its own that waits for textures.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``: Node.js or the package is not installed; or the encoder ended.
    """
    node, package = shutil.which("node"), find_package()
    if node is None or package is None:
        missing = "Node.js" if node is None else f"its package {PACKAGE}"
        raise FaceZipError(
            ErrorCode.MISSING_FILE,
            f"--textures ktx2 for glTF: {missing} is not installed; run 'npm install {PACKAGE}' here, or take png",
        )
    command = [node, str(SCRIPT), str(package)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as encoder:
        try:
            yield _codec(encoder)
        finally:
            encoder.kill()


def find_package() -> Path | None:
    """The folder of ``ktx2-encoder``: in ``NODE_PATH``, or in the ``node_modules`` of this folder or one above it."""
    places = [Path(place) for place in os.environ.get("NODE_PATH", "").split(os.pathsep) if place]
    places += [folder / "node_modules" for folder in (Path.cwd(), *Path.cwd().parents)]
    return next((place / PACKAGE for place in places if (place / PACKAGE / "package.json").is_file()), None)


def _codec(encoder: subprocess.Popen[bytes]) -> Codec:
    # A transcoder answers with the texels at once: what was seen of blocks is kept until it is asked for.
    seen: dict[bytes, bytes] = {}

    def encode(texels: bytes, width: int, height: int) -> bytes:
        blocks, rgba = _ask(encoder, struct.pack("<II", width, height) + texels, width * height)
        seen[blocks] = rgba
        return blocks

    def decode(blocks: bytes, width: int, height: int) -> bytes:
        rgba = memoryview(seen.pop(blocks))
        bgra = bytearray(rgba)
        bgra[0::4], bgra[2::4] = rgba[2::4], rgba[0::4]
        return bytes(bgra)

    return of_library("uastc", (4, 4), 16, encode, decode, band=0)


def _ask(encoder: subprocess.Popen[bytes], question: bytes, texels: int) -> tuple[bytes, bytes]:
    """Blocks, and the RGBA texels that a transcoder makes of them."""
    if encoder.stdin is None or encoder.stdout is None:
        raise ValueError("the encoder has no pipes")
    try:
        encoder.stdin.write(question)
        encoder.stdin.flush()
    except OSError:
        raise _ended() from None
    return _read(encoder.stdout, texels), _read(encoder.stdout, 4 * texels)


def _read(pipe: IO[bytes], count: int) -> bytes:
    content = pipe.read(count)
    if len(content) != count:
        raise _ended()
    return content


def _ended() -> FaceZipError:
    return FaceZipError(
        ErrorCode.MISSING_FILE, f"{PACKAGE}: the encoder ended early; install it again, or take --textures png"
    )
