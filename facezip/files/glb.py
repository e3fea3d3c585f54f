"""glTF files, binary or with files beside them: one JSON document, buffers, and the arrays that its accessors describe.

Libraries at hand drop morph targets (trimesh) or leave accessors, sparse ones above all, to the caller (pygltflib).
What a blendshape needs of the format is little, and every offset of a stranger's file has to be checked.
"""

import json
import os
from codecs import BOM_UTF8
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.accessors import COMPONENTS, GlbFault, GltfObject, amount, layout, normalised, strided
from facezip.files.glb_chunks import BINARY_CHUNK, HEADER, JSON_CHUNK, check_header, chunk, chunks_of, header
from facezip.files.links import MAX_BYTES, REMEDY, Links, without_data

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
                check_header(start, size)
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
        check_header(content[:HEADER], len(content))
        chunks = dict(chunks_of(content))
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
        chunks = chunk(JSON_CHUNK, text, b" ") + (chunk(BINARY_CHUNK, self.binary, b"\0") if self.binary else [])
        return [header(sum(map(len, chunks))), *chunks]

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
