"""What a glTF refers to by URIs: bytes in the URI itself, or a file in the folder that it lies in, and no more."""

import base64
import binascii
import json
import re
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

from facezip.files.accessors import GlbFault

MAX_BYTES = 2**31
REMEDY = "export one .glb with everything in it"
_DATA = re.compile(rb'(?<!\\)"(data:[^"\\]*(?:\\.[^"\\]*)*)"')
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")
_TAKEN_OUT = "data:#"


def without_data(text: bytes) -> tuple[bytes, list[bytes]]:
    """A JSON text with a number in the place of each data URI, and those: parsed, they would be held several times."""
    taken: list[bytes] = []

    def number(found: re.Match[bytes]) -> bytes:
        taken.append(found[1])
        return f'"{_TAKEN_OUT}{len(taken) - 1}"'.encode()

    return _DATA.sub(number, text), taken


class Links:
    """The URIs of one glTF.

    Parameters
    ----------
    folder : where files lie that it may refer to; None for a file that has to hold everything itself.
    data : the data URIs that :func:`without_data` took out of it.
    """

    def __init__(self, folder: Path | None = None, data: Sequence[bytes] = ()) -> None:
        self._folder, self._data = folder, data
        self._held: dict[str | Path, bytes] = {}

    @property
    def bytes_held(self) -> int:
        """Bytes of all contents that were asked for."""
        return sum(map(len, self._held.values()))

    def file(self, uri: str) -> Path | None:
        """The file that a URI refers to, which is there; None where the URI is the data.

        Raises
        ------
        GlbFault
            It is another address, outside of the folder, or not there.
        """
        if uri.startswith("data:"):
            return None
        shown = repr(uri[:128])
        if self._folder is None:
            raise GlbFault(f"it refers to {shown}, which is another file; {REMEDY}")
        name = unquote(uri).replace("\\", "/")
        if _SCHEME.match(name) or name.startswith("/") or "\0" in name:
            raise GlbFault(f"it refers to {shown}, and only files beside it are read; copy that here, or {REMEDY}")
        path = self._folder / name
        if not path.resolve().is_relative_to(self._folder.resolve()):
            raise GlbFault(f"it refers to {shown}, which is outside of its folder; copy that into it, or {REMEDY}")
        if not path.is_file():
            raise GlbFault(f"it refers to {shown}, which is not there; put the file back beside it, or {REMEDY}")
        return path

    def content(self, uri: str) -> bytes:
        """The bytes that a URI refers to; ``GlbFault`` as of :meth:`file`, or where they are no data."""
        path = self.file(uri)
        key = uri if path is None else path.resolve()
        if key not in self._held:
            self._held[key] = self._decoded(uri) if path is None else _content_of(path)
        return self._held[key]

    def _decoded(self, uri: str) -> bytes:
        number = uri.removeprefix(_TAKEN_OUT)
        stated = self._data[int(number)] if number.isdecimal() and int(number) < len(self._data) else uri.encode()
        if b"\\" in stated:
            # JSON may escape slashes, of which base64 has many.
            stated = json.loads(b'"' + stated + b'"').encode()
        head, comma, body = stated.partition(b",")
        try:
            if not comma:
                raise ValueError
            return base64.b64decode(body, validate=True) if head.endswith(b";base64") else unquote_to_bytes(body)
        except (ValueError, binascii.Error):
            raise GlbFault("a data URI of it is not whole base64; export it again") from None


def _content_of(path: Path) -> bytes:
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise GlbFault(f"{path.name}, which it refers to, has {size} bytes; up to {MAX_BYTES} are read")
    return path.read_bytes()
