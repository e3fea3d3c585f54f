"""Arrays within the buffers of a glTF: how its accessors lay numbers out, checked against the bytes that there are."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

COMPONENTS: dict[int, type[np.generic]] = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
CODES = {np.dtype(kind): code for code, kind in COMPONENTS.items()}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {width: name for name, width in WIDTHS.items()}


# One object of the JSON of a glTF file; its specification says what is in it.
GltfObject = dict[str, Any]


class GlbFault(ValueError):
    """What is wrong with a glTF, before the file's name is put in front."""


def amount(value: Any) -> int:
    """A number of bytes or values; ``GlbFault`` for anything else."""
    if type(value) is not int or not 0 <= value < 2**32:
        raise GlbFault(f"{repr(value)[:64]} is no count of bytes or values; export it again")
    return value


def layout(accessor: Mapping[str, Any]) -> tuple[np.dtype[Any], int, int]:
    """Type, width and count of the values of an accessor."""
    kind, width = COMPONENTS.get(accessor.get("componentType", 0)), WIDTHS.get(str(accessor.get("type")))
    if kind is None or width is None:
        raise GlbFault(
            f"an accessor of {str(accessor.get('type'))[:64]} is not read here; export plain triangle meshes"
        )
    return np.dtype(kind).newbyteorder("<"), width, amount(accessor.get("count"))


def strided(content: bytes, start: int, stride: int, kind: np.dtype[Any], rows: int, width: int) -> NDArray[Any]:
    """``(rows, width)`` values from ``start`` on, ``stride`` bytes apart; 0 where one follows the other."""
    step = stride or kind.itemsize * width
    last = start + (rows - 1) * step + kind.itemsize * width
    if rows and (last > len(content) or step < kind.itemsize * width):
        raise GlbFault("an accessor reads past the end of its data; export it again")
    if not rows:
        return np.zeros((0, width), kind)
    return np.ndarray((rows, width), kind, content, start, (step, kind.itemsize))


def normalised(values: NDArray[Any]) -> NDArray[np.float32]:
    """Integers over their largest number, at least -1."""
    if values.dtype.kind == "f":
        return values
    floats: NDArray[np.float32] = np.maximum(values / np.float32(np.iinfo(values.dtype).max), -1).astype(np.float32)
    return floats


def accessor_of(values: NDArray[Any], bounds: bool) -> GltfObject:
    """The accessor of ``(count, width)`` values, without where they are."""
    entry = {"componentType": CODES[values.dtype], "count": len(values), "type": TYPES[values.shape[1]]}
    if not bounds:
        return entry
    low, high = values.min(axis=0).tolist(), values.max(axis=0).tolist()
    if not all(map(math.isfinite, (*low, *high))):
        raise ValueError("values of a mesh have to be finite")
    return entry | {"min": low, "max": high}
