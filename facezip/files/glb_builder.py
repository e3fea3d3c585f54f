"""Binary glTF files as they are written: arrays and images of one buffer, by accessors and views."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.accessors import CODES, GltfObject, accessor_of
from facezip.files.glb import Glb

VERTICES, INDICES = 34962, 34963


@dataclass
class GlbBuilder:
    """Collects arrays and images into the binary chunk, and the lists of the document that describe them.

    Attributes
    ----------
    document : the JSON to be; ``buffers``, ``bufferViews`` and ``accessors`` are filled here.
    gathered : whether sparse arrays share one buffer view, since two for each of four thousand targets would fill the
        JSON. Godot prints an error for each that does not have two of its own.
    """

    document: GltfObject
    gathered: bool = False
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

    def _scatter(self, content: bytes) -> GltfObject:
        if not self.gathered:
            return {"bufferView": self.view(content)}
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
