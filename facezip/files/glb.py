"""glTF files, binary or with files beside them: one JSON document, buffers, and the arrays that its accessors describe.

Libraries at hand drop morph targets (trimesh) or leave accessors, sparse ones above all, to the caller (pygltflib).
What a blendshape needs of the format is little, and every offset of a stranger's file has to be checked.
"""

import json
import os
import struct
from codecs import BOM_UTF8
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.accessors import CODES, COMPONENTS, GltfObject, accessor_of, amount, layout, normalised, strided
from facezip.files.accessors import GlbFault as GlbFault
from facezip.files.links import MAX_BYTES, REMEDY, Links, without_data

MAGIC, VERSION = b"glTF", 2
# Of the file and of its first chunk.
HEADER = 20
JSON_CHUNK, BINARY_CHUNK = b"JSON", b"BIN\0"
VERTICES, INDICES = 34962, 34963
# A parsed list takes up to 30 times its text. Data in URIs do not count.
MAX_JSON = 2 * 2**20
COMPRESSED_VIEWS = ("EXT_meshopt_compression", "KHR_meshopt_compression")


@dataclass(frozen=True)
class Glb:
    """A file in memory.

    Attributes
    ----------
    document : the JSON.
    binary : the binary chunk, perhaps with up to three bytes of padding.
    links : what its URIs refer to.
    """

    document: GltfObject
    binary: bytes = b""
    links: Links = field(default_factory=Links)

    @classmethod
    def read(cls, path: Path) -> "Glb":
        """Read a file of either form, whatever it is called, with links to files in its folder.

        No more of it is held than it states and may have; ``GlbFault`` where its lengths or its JSON are not right.
        """
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > MAX_BYTES:
                raise GlbFault(f"{size} bytes; up to {MAX_BYTES} are read, export it with smaller textures")
            start = file.read(HEADER)
            is_text = start.removeprefix(BOM_UTF8).lstrip()[:1] == b"{"
            if not is_text:
                _check_header(start, size)
            content = start + file.read(size)
        return cls._of(content, b"", path.parent) if is_text else cls.parse(content, path.parent)

    @classmethod
    def parse(cls, content: bytes, folder: Path | None = None) -> "Glb":
        """Split a binary file into its chunks; ``GlbFault`` where its lengths or its JSON are not right.

        Parameters
        ----------
        content : the file.
        folder : where files lie that it may refer to; None where it has to hold everything itself.
        """
        _check_header(content[:HEADER], len(content))
        chunks = dict(_chunks(content))
        return cls._of(chunks.get(JSON_CHUNK, b""), chunks.get(BINARY_CHUNK, b""), folder)

    @classmethod
    def _of(cls, text: bytes, binary: bytes, folder: Path | None) -> "Glb":
        text, data = without_data(text)
        if len(text) > MAX_JSON:
            raise GlbFault(f"its JSON has {len(text)} bytes, up to {MAX_JSON} are read; export the face alone")
        try:
            document = json.loads(text)
        except (ValueError, RecursionError):
            raise GlbFault("its JSON is not readable; export it again") from None
        if not isinstance(document, dict):
            raise GlbFault("its JSON is no object; export it again")
        return cls(document, binary, Links(folder, data))

    def to_bytes(self) -> bytes:
        """The file's content."""
        return b"".join(self._pieces())

    def write(self, path: Path) -> None:
        """Write the file, of which nothing is copied."""
        with open(path, "wb") as file:
            file.writelines(self._pieces())

    def _pieces(self) -> list[bytes]:
        text = json.dumps(self.document, separators=(",", ":"), allow_nan=False, ensure_ascii=False).encode()
        chunks = _chunk(JSON_CHUNK, text, b" ") + (_chunk(BINARY_CHUNK, self.binary, b"\0") if self.binary else [])
        return [MAGIC + struct.pack("<II", VERSION, 12 + sum(map(len, chunks))), *chunks]

    def item(self, kind: str, index: Any) -> GltfObject:
        """One entry of ``"meshes"``, ``"images"`` ...; ``GlbFault`` where there is none of that number."""
        entries = self.document.get(kind, [])
        if not isinstance(entries, list) or type(index) is not int or not 0 <= index < len(entries):
            raise GlbFault(f"it uses number {index} of its {kind}, which does not exist; export it again")
        if not isinstance(entries[index], dict):
            raise GlbFault(f"number {index} of its {kind} is no object; export it again")
        return dict(entries[index])

    def buffer(self, index: Any) -> bytes:
        """The bytes of a buffer: the binary chunk, or what its URI refers to."""
        buffer = self.item("buffers", index)
        if "uri" in buffer:
            return self.links.content(str(buffer["uri"]))
        if index or not self.binary:
            raise GlbFault(f"its buffer {index} is empty; {REMEDY}")
        return self.binary

    @property
    def bytes_held(self) -> int:
        """Bytes of the buffers that were asked for."""
        return len(self.binary) + self.links.bytes_held

    def view(self, index: Any) -> bytes:
        """The bytes of a buffer view."""
        view = self.item("bufferViews", index)
        compressed = [name for name in COMPRESSED_VIEWS if name in view.get("extensions", {})]
        if compressed and "uri" not in self.item("buffers", view.get("buffer")):
            raise GlbFault(f"its data are compressed by {compressed[0]}, which is not read; export it uncompressed")
        buffer = self.buffer(view.get("buffer"))
        start, length = amount(view.get("byteOffset", 0)), amount(view.get("byteLength"))
        if start + length > len(buffer):
            raise GlbFault(f"buffer view {index} lies past the end of the file; export it again")
        return buffer[start : start + length]

    def array(self, index: Any) -> NDArray[Any]:
        """The values of an accessor, ``(count, width)``: float32 where float or normalised, else integers as stored."""
        accessor = self.item("accessors", index)
        kind, width, count = layout(accessor)
        if "bufferView" in accessor:
            stride = self.item("bufferViews", accessor["bufferView"]).get("byteStride", 0)
            start = amount(accessor.get("byteOffset", 0))
            values = strided(self.view(accessor["bufferView"]), start, amount(stride), kind, count, width)
        else:
            # Without bytes it is all zeros, whatever its count says; something else has as many values.
            if count > self.bytes_held:
                raise GlbFault(f"accessor {index} states {count} values and holds none; export it again")
            values = np.zeros((count, width), kind)
        if "sparse" in accessor:
            values = self._replaced(values, accessor["sparse"])
        return normalised(values) if accessor.get("normalized") else values

    def _replaced(self, values: NDArray[Any], sparse: Mapping[str, Any]) -> NDArray[Any]:
        count = amount(sparse["count"])
        where, what = sparse["indices"], sparse["values"]
        kind = np.dtype(COMPONENTS.get(where["componentType"], np.float32))
        if kind.kind != "u":
            raise GlbFault("a sparse accessor has indices that are no integers; export it again")
        start = amount(where.get("byteOffset", 0))
        rows = strided(self.view(where["bufferView"]), start, 0, kind, count, 1)[:, 0]
        start = amount(what.get("byteOffset", 0))
        new = strided(self.view(what["bufferView"]), start, 0, values.dtype, count, values.shape[1])
        if count and rows.max() >= len(values):
            raise GlbFault("a sparse accessor writes past its end; export it again")
        values = values.copy()
        values[rows] = new
        return values


@dataclass
class GlbBuilder:
    """Collects arrays and images into the binary chunk, and the lists of the document that describe them.

    Attributes
    ----------
    document : the JSON to be; ``buffers``, ``bufferViews`` and ``accessors`` are filled here.
    """

    document: GltfObject
    _binary: bytearray = field(default_factory=bytearray)
    _scattered: bytearray = field(default_factory=bytearray)
    _scattered_view: int | None = None

    def view(self, content: bytes, target: int | None = None, stride: int | None = None) -> int:
        """Add bytes, aligned to four; returns the number of the buffer view."""
        view = self._placed(content) | ({"byteStride": stride} if stride else {})
        return self._add("bufferViews", view | ({"target": target} if target else {}))

    def array(
        self, values: NDArray[Any], target: int | None = None, bounds: bool = False, normalized: bool = False
    ) -> int:
        """Add ``(count, width)`` values, rows of vertices aligned to four bytes; returns the number of the accessor."""
        rows = np.ascontiguousarray(values).view(np.uint8)
        padding = -rows.shape[1] % 4 if target == VERTICES else 0
        if padding:
            rows = np.pad(rows, ((0, 0), (0, padding)))
        view = self.view(rows.tobytes(), target, rows.shape[1] if padding else None)
        described = accessor_of(values, bounds) | ({"normalized": True} if normalized else {})
        return self._add("accessors", {"bufferView": view, **described})

    def sparse(self, values: NDArray[Any], bounds: bool = False) -> int:
        """Add ``(count, width)`` values of which most are zero, by their rows that are not, where that saves bytes."""
        rows = np.flatnonzero(values.any(axis=1))
        described = accessor_of(values, bounds)
        if len(rows) == 0:
            return self._add("accessors", described)
        kind: type[np.generic] = np.uint16 if rows[-1] < 2**16 else np.uint32
        width = values[:1].nbytes
        if len(rows) * (width + np.dtype(kind).itemsize) >= len(values) * (width + -width % 4):
            return self.array(values, VERTICES, bounds)
        sparse = {
            "count": len(rows),
            "indices": {**self._scatter(rows.astype(kind).tobytes()), "componentType": CODES[np.dtype(kind)]},
            "values": self._scatter(values[rows].tobytes()),
        }
        return self._add("accessors", described | {"sparse": sparse})

    def image(self, name: str, content: bytes, mime: str) -> int:
        """Add an encoded image; returns its number."""
        return self._add("images", {"name": name, "mimeType": mime, "bufferView": self.view(content)})

    def finish(self) -> Glb:
        """The file; nothing may be added afterwards."""
        if self._scattered_view is not None:
            self.document["bufferViews"][self._scattered_view] = self._placed(self._scattered)
        self._binary += bytes(-len(self._binary) % 4)
        self.document["buffers"] = [{"byteLength": len(self._binary)}]
        return Glb(self.document, bytes(self._binary))

    def _placed(self, content: bytes | bytearray) -> GltfObject:
        self._binary += bytes(-len(self._binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(content)}
        self._binary += content
        return view

    # One buffer view for all: two for each of four thousand targets would fill the JSON.
    def _scatter(self, content: bytes) -> GltfObject:
        if self._scattered_view is None:
            self._scattered_view = self._add("bufferViews", {})
        self._scattered += bytes(-len(self._scattered) % 4)
        place = {"bufferView": self._scattered_view, "byteOffset": len(self._scattered)}
        self._scattered += content
        return place

    def _add(self, kind: str, entry: GltfObject) -> int:
        entries: list[GltfObject] = self.document.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1


def _check_header(header: bytes, size: int) -> None:
    if size < HEADER or header[:4] != MAGIC:
        raise GlbFault("it does not begin with 'glTF'; export it as a binary .glb")
    version, length = struct.unpack_from("<II", header, 4)
    if version != VERSION or length != size:
        raise GlbFault(f"version {version}, {size} bytes where it states {length}; copy or export it again")


def _chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    found, start = [], 12
    while start < len(content):
        if start + 8 > len(content):
            raise GlbFault("it ends within a chunk; copy or export it again")
        length, kind = struct.unpack_from("<I4s", content, start)
        if start + 8 + length > len(content):
            raise GlbFault("it ends within a chunk; copy or export it again")
        found.append((kind, content[start + 8 : start + 8 + length]))
        start += 8 + length
    # The first of a kind counts.
    return found[::-1]


def _chunk(kind: bytes, content: bytes, padding: bytes) -> list[bytes]:
    past = padding * (-len(content) % 4)
    return [struct.pack("<I4s", len(content) + len(past), kind), content, past]
