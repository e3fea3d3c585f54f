"""The range of every field of a manifest: what a reader refuses before it opens another file (docs/pack-format.md)."""

import math
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from facezip.files.names import MAX_CHARACTERS, first_unusable
from facezip.files.obj import LONGEST_LINE
from facezip.files.opening import MAX_SIDE
from facezip.files.reading import MOST_EXPANSION, SPARE
from facezip.pack.footprint import SLOTS_PER_LAYER

if TYPE_CHECKING:
    from facezip.pack.manifest import Manifest
    from facezip.pack.surface_manifest import AnyManifest

NEUTRAL_FILE = "neutral.png"
MESH_FILE = "neutral.obj"
DELTAS_FILE = "deltas.f32"
MAX_EXPRESSIONS = 4096
MAX_DIFFERENCES = 8
# An atlas of many weight maps is larger than a texture may be.
MAX_ATLAS_SIDE = 2**16
MAX_CORNERS = 2**24
MAX_NUMBER = 1e9

SHA256 = re.compile(r"[0-9a-f]{64}")


def first_out_of_range(manifest: "Manifest") -> str | None:
    """The name of the first field that is outside its range, None where all are inside."""
    return next((name for name, passed in _checks(manifest) if not passed), None)


def difference_files(manifest: "Manifest") -> list[str]:
    """The image of each difference texture."""
    return [f"difference_{i}.png" for i in range(len(manifest.difference_scale))]


def weight_files(manifest: "Manifest") -> list[str]:
    """The atlas of every four slots; none for uniform weights."""
    layers = -(-len(manifest.difference_scale) // SLOTS_PER_LAYER)
    return [] if manifest.uniform_weights else ["weights.png", *(f"weights_{n}.png" for n in range(1, layers))]


def atlas_shape(manifest: "Manifest") -> tuple[int, int, int]:
    """Rows, columns and channels of the image that holds the weight maps of four slots."""
    h, w = manifest.weight_size
    return -(-len(manifest.expressions) // manifest.weight_columns) * h, manifest.weight_columns * w, SLOTS_PER_LAYER


# Lazily: each check may rely on those before it.
def _checks(m: "Manifest") -> Iterator[tuple[str, bool]]:
    yield from common_checks(m)
    yield "size", is_size(m.size)
    yield "channels", is_count(m.channels, 1, 4)
    yield "neutral_bits", type(m.neutral_bits) is int and m.neutral_bits in (8, 16)
    yield "encoding", m.encoding == "srgb"
    yield "difference_scale", is_table(m.difference_scale, (1, MAX_DIFFERENCES), m.channels, 0)
    slots, count = len(m.difference_scale), len(m.expressions)
    yield "weight_size", is_size(m.weight_size) and all(a <= b for a, b in zip(m.weight_size, m.size, strict=True))
    yield "weight_columns", is_count(m.weight_columns, 1, count)
    yield "weight_scale", are_numbers(m.weight_scale, slots, 0)
    yield "weight_offset", are_numbers(m.weight_offset, slots, -MAX_NUMBER)
    rows = count if m.weight_size == (1, 1) else 0
    yield "uniform_weights", is_table(m.uniform_weights, (rows, rows), slots, -MAX_NUMBER)
    yield "weight_columns", max(atlas_shape(m)) <= MAX_ATLAS_SIDE
    yield from _file_checks(m)


def common_checks(m: "AnyManifest") -> Iterator[tuple[str, bool]]:
    """What every version states alike: names, method, meshes."""
    yield "name", isinstance(m.name, str) and len(m.name) <= MAX_CHARACTERS and m.name.isprintable()
    yield "method", isinstance(m.method, str) and 0 < len(m.method) <= MAX_CHARACTERS and m.method.isprintable()
    yield "expressions", is_list(m.expressions, 1, MAX_EXPRESSIONS) and are_names(m.expressions)
    yield "made_with", isinstance(m.made_with, dict)
    corners = {"vertices": m.vertices, "triangles": m.triangles, "texture_coordinates": m.texture_coordinates}
    for name, value in corners.items():
        yield name, is_count(value, 0, MAX_CORNERS) and (value > 0) == (m.vertices > 0)


def _file_checks(m: "Manifest") -> Iterator[tuple[str, bool]]:
    yield from stored_checks(m, [NEUTRAL_FILE, *difference_files(m), *weight_files(m)])
    texture = math.prod((*m.size, m.channels))
    for name in [NEUTRAL_FILE, *difference_files(m)]:
        yield "size", is_in_proportion(texture * (m.neutral_bits // 8 if name == NEUTRAL_FILE else 1), m, name)
    for name in weight_files(m):
        yield "weight_size", is_in_proportion(math.prod(atlas_shape(m)), m, name)


def stored_checks(m: "AnyManifest", images: list[str]) -> Iterator[tuple[str, bool]]:
    """The files that there must be: images and, where stated, meshes."""
    yield "files", {*m.files} == {*images, *([MESH_FILE, DELTAS_FILE] if m.vertices else [])}
    for file in m.files.values():
        yield "files", isinstance(file.sha256, str) and SHA256.fullmatch(file.sha256) is not None
        yield "files", is_count(file.bytes, 1, 2**40)
    if m.vertices:
        lines = m.vertices + m.triangles + m.texture_coordinates
        yield "vertices", 4 * lines <= m.files[MESH_FILE].bytes <= LONGEST_LINE * lines
        yield "vertices", m.files[DELTAS_FILE].bytes == len(m.expressions) * m.vertices * 3 * 4


def is_in_proportion(decoded: int, m: "AnyManifest", name: str) -> bool:
    """Whether a file unfolds to so many bytes that it may well hold them."""
    return decoded <= max(SPARE, MOST_EXPANSION * m.files[name].bytes)


def are_names(names: tuple[Any, ...]) -> bool:
    """Whether all are safe names, and different ones to every file system."""
    return all(isinstance(name, str) for name in names) and first_unusable(names) is None


def is_size(size: Any) -> bool:
    """Whether these are rows and columns of an image."""
    return is_list(size, 2, 2) and all(is_count(side, 1, MAX_SIDE) for side in size)


def is_table(rows: Any, counts: tuple[int, int], columns: int, low: float) -> bool:
    """Whether there are as many rows as allowed, each of so many numbers."""
    return is_list(rows, *counts) and all(are_numbers(row, columns, low) for row in rows)


def are_numbers(values: Any, count: int, low: float) -> bool:
    """Whether these are so many numbers of at least ``low``."""
    return is_list(values, count, count) and all(is_number(value, low) for value in values)


def is_list(values: Any, fewest: int, most: int) -> bool:
    """Whether this is a list of an allowed length."""
    return isinstance(values, tuple) and fewest <= len(values) <= most


def is_count(value: Any, low: int, high: int) -> bool:
    """Whether this is a whole number within a range, and no truth value."""
    return type(value) is int and low <= value <= high


def is_number(value: Any, low: float) -> bool:
    """Whether this is a number of at least ``low``, and none that is huge."""
    return type(value) in (int, float) and low <= value <= MAX_NUMBER
