"""The images of a glTF as files that the readers of textures take: within it, in its URIs, or beside it."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import unquote

from facezip.errors import FaceZipError
from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb
from facezip.files.links import REMEDY
from facezip.files.opening import TEXTURE_SUFFIXES

# How images begin that glTF may hold, and some that it may not: what an image is called or said to be does not count.
_READ = {b"\x89PNG\r\n\x1a\n": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp"}
_OTHERS = {b"\xabKTX 20\xbb": "KTX2 (Basis Universal)", b"DDS ": "DDS", b"GIF8": "GIF", b"BM": "BMP"}


class Images:
    """The images of one file.

    Parameters
    ----------
    path, glb : the file.
    """

    def __init__(self, path: Path, glb: Glb) -> None:
        self._path, self._glb = path, glb

    def name(self, index: int) -> str:
        """What an image is called: by its name, or the file that it is; without the suffix of an image."""
        image = self._glb.item("images", index)
        uri = str(image.get("uri", ""))
        file = "" if uri.startswith("data:") else unquote(uri).replace("\\", "/")
        name = Path(str(image.get("name") or Path(file).name))
        return name.stem if name.suffix.lower() in TEXTURE_SUFFIXES else name.name

    def shown(self, source: int | Path) -> str:
        """An image, or a file beside, in the words of a message."""
        if isinstance(source, Path):
            return source.name
        name = self.name(source)
        return f"image {source}" + (f" ('{name[:64]}')" if name else "")

    def stored_bytes(self, source: int | Path) -> int:
        """Bytes of its file, where it has one; those within the glTF are a part of that."""
        file = source if isinstance(source, Path) else self._file(self._glb.item("images", source))
        return 0 if file is None else file.stat().st_size

    @contextmanager
    def file(self, source: int | Path) -> Iterator[Path]:
        """A file with the image, which is there no longer than this; what is wrong with it is said of the glTF."""
        image = {} if isinstance(source, Path) else self._glb.item("images", source)
        beside = source if isinstance(source, Path) else self._file(image)
        if beside is not None:
            yield beside
            return
        with tempfile.TemporaryDirectory() as folder:
            content = self._content(image, self.shown(source))
            file = Path(folder) / f"image{_suffix(content, self.shown(source))}"
            file.write_bytes(content)
            try:
                yield file
            except FaceZipError as error:
                reason = str(error).replace(str(file), f"{self._path}: {self.shown(source)}", 1)
                raise FaceZipError(error.code, reason) from None

    def _file(self, image: GltfObject) -> Path | None:
        return self._glb.links.file(str(image["uri"])) if "uri" in image else None

    def _content(self, image: GltfObject, shown: str) -> bytes:
        if "uri" in image:
            return self._glb.links.content(str(image["uri"]))
        if image.get("bufferView") is None:
            raise GlbFault(f"{shown} is neither in it nor beside it; {REMEDY}")
        return self._glb.view(image["bufferView"])


def _suffix(content: bytes, shown: str) -> str:
    for start, suffix in _READ.items():
        if content.startswith(start):
            return suffix
    kind = next((kind for start, kind in _OTHERS.items() if content.startswith(start)), "no image known here")
    raise GlbFault(f"{shown} is {kind}, which is not read; export it with PNG or JPEG textures")
