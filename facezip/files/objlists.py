"""The plain lines of an OBJ file, many at once: ``v``, ``vt``, ``vn``, ``f``, blank lines and remarks.

Whatever is unusual in the least is left to :mod:`facezip.files.objlines`, which reads any line, and the same of these.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel

MAX_COORDINATE = 1e30
# Bytes that are looked at together: few enough that their memory is used again.
PART = 2**18

_F, _N, _T, _V, _E, _ZERO = b"fntve0"
_PLUS, _MINUS, _POINT, _SLASH, _REMARK, _BACKSLASH = b"+-./#\\"
# What a byte is.
_WORD, _BLANK, _LINE_END = range(3)
_KINDS = np.full(256, _WORD, np.uint8)
_KINDS[list(b" \t")], _KINDS[list(b"\n\r")] = _BLANK, _LINE_END
# Ten times as much fits into 64 bits; digits behind that many are below a float64's precision.
_FULL = 10**17
# Indices are 32 bits wide.
_INDEX_DIGITS = 9
# A vertex with a weight and a colour.
_MOST_NUMBERS = 7
_POWERS = 10.0 ** np.arange(64)
# Ten units in the last place of a float64: twice what a long mantissa, a power and their product can be off.
_DOUBT = 1e-15
# More than any list holds.
_NORMALS = 2**40
# Columns of ``Lists.counts``.
VERTICES, UVS, CORNERS, FACES = range(4)


class Lists(NamedTuple):
    """What the lines of a file add up to; of each list, as many rows are filled as ``counts`` says.

    Attributes
    ----------
    vertices : ``(L, 3)`` float32.
    uv : ``(L, 2)`` float32.
    corners : ``(C, 2)`` int32, vertex and UV of each corner, from 0; not yet compared with how many there are.
    faces : ``(L, 2)`` int32, where each face's corners end, and where its line begins.
    counts : ``(4,)`` int64, filled rows of these four.
    numbers : ``(7,)`` float64, room for those of a line.
    """

    vertices: NDArray[np.float32]
    uv: NDArray[np.float32]
    corners: NDArray[np.int32]
    faces: NDArray[np.int32]
    counts: NDArray[np.int64]
    numbers: NDArray[np.float64]

    @staticmethod
    def sized_for(text: bytes | bytearray) -> "Lists":
        """Empty lists in which ``text`` finds room: corners have slashes, but for one that is looked at and refused."""
        lines, corners = occurrences(text, b"\n") + occurrences(text, b"\r") + 1, occurrences(text, b"/") + 1
        return Lists(
            np.empty((lines, 3), np.float32),
            np.empty((lines, 2), np.float32),
            np.empty((corners, 2), np.int32),
            np.empty((lines, 2), np.int32),
            np.zeros(4, np.int64),
            np.empty(_MOST_NUMBERS),
        )


def occurrences(text: bytes | bytearray, byte: bytes) -> int:
    """How often a byte occurs; ``bytes.count`` takes five times as long where that is often."""
    values = np.frombuffer(text, np.uint8)
    return sum(
        int(np.count_nonzero(values[begin : begin + PART] == ord(byte))) for begin in range(0, len(values), PART)
    )


@kernel()
def read_plain_lines(text: NDArray[np.uint8], at: int, lists: Lists) -> int:
    """Read lines of ``text``, which ends in a line end, from ``at`` on; where the first begins that is not plain."""
    vertices, uv, corners, faces, counts, numbers = lists
    while at < len(text):
        begin = at
        at = _skip_blanks(text, at)
        if text[at] == _REMARK:
            at = _skip_remark(text, at)
        elif text[at] == _F and _KINDS[text[at + 1]] == _BLANK:
            at = _read_face(text, at + 1, begin, corners, faces, counts)
        elif text[at] == _V:
            at = _read_numbers(text, at + 1, vertices, uv, counts, numbers)
        elif _KINDS[text[at]] != _LINE_END:
            at = -1
        if at < 0:
            return begin
        at += 1
    return at


@inner()
def _skip_remark(text: NDArray[np.uint8], at: int) -> int:
    while _KINDS[text[at]] != _LINE_END:
        at += 1
    return -1 if text[at - 1] == _BACKSLASH else at


@inner()
def _read_numbers(
    text: NDArray[np.uint8],
    at: int,
    vertices: NDArray[np.float32],
    uv: NDArray[np.float32],
    counts: NDArray[np.int64],
    numbers: NDArray[np.float64],
) -> int:
    """Read what follows the ``v`` of a ``v``, ``vt`` or ``vn`` line; the line's end, or -1."""
    key = text[at]
    is_uv, is_normal = key == _T, key == _N
    at += is_uv or is_normal
    if _KINDS[text[at]] != _BLANK:
        return -1
    count = 0
    at = _skip_blanks(text, at)
    while _KINDS[text[at]] != _LINE_END:
        if count == len(numbers):
            return -1
        numbers[count], at = _number(text, at)
        if at < 0:
            return -1
        count += 1
        at = _skip_blanks(text, at)
    if is_normal:
        return at if count == 3 else -1
    if is_uv:
        if count != 2 and count != 3:
            return -1
        row = counts[UVS]
        uv[row, 0], uv[row, 1] = numbers[0], numbers[1]
        counts[UVS] += 1
        return at
    if count < 3 or count == 5 or (count == 4 and numbers[3] != 1):
        return -1
    row = counts[VERTICES]
    for column in range(3):
        vertices[row, column] = numbers[column]
    counts[VERTICES] += 1
    return at


@inner()
def _number(text: NDArray[np.uint8], at: int) -> tuple[float, int]:
    """The decimal number at ``at``, and where it ends; -1 where it is none, or might round to another float32."""
    negative = text[at] == _MINUS
    at += negative or text[at] == _PLUS
    begin = at
    mantissa, at, left_out = _digits(text, at, 0)
    exponent, digits = left_out, at - begin
    if text[at] == _POINT:
        begin = at + 1
        mantissa, at, left_out = _digits(text, begin, mantissa)
        exponent += left_out - (at - begin)
        digits += at - begin
    if digits > 0 and text[at] | 0x20 == _E:
        below = text[at + 1] == _MINUS
        begin = at + (2 if below or text[at + 1] == _PLUS else 1)
        power, at, left_out = _digits(text, begin, 0)
        digits *= at > begin and power < 1000
        exponent += -power if below else power
    if digits == 0 or abs(exponent) >= len(_POWERS) or _KINDS[text[at]] == _WORD:
        return 0.0, -1
    value = mantissa * _POWERS[exponent] if exponent >= 0 else mantissa / _POWERS[-exponent]
    certain = np.float32(value * (1 - _DOUBT)) == np.float32(value * (1 + _DOUBT))
    return -value if negative else value, at if certain and value < MAX_COORDINATE else -1


@inner()
def _digits(text: NDArray[np.uint8], at: int, value: int) -> tuple[int, int, int]:
    """``value`` with the digits at ``at`` behind it, where they end, and how many of them it did not hold any more."""
    left_out = 0
    digit = text[at] - _ZERO
    while 0 <= digit <= 9:
        if value < _FULL:
            value = 10 * value + digit
        else:
            left_out += 1
        at += 1
        digit = text[at] - _ZERO
    return value, at, left_out


@inner()
def _read_face(
    text: NDArray[np.uint8],
    at: int,
    begin: int,
    corners: NDArray[np.int32],
    faces: NDArray[np.int32],
    counts: NDArray[np.int64],
) -> int:
    """Read the corners ``v/vt``, ``v/vt/`` or ``v/vt/vn`` of a face, all alike; the line's end, or -1."""
    vertices, uvs = counts[VERTICES], counts[UVS]
    corner, alike = counts[CORNERS], 0
    at = _skip_blanks(text, at)
    while _KINDS[text[at]] != _LINE_END:
        parts, vertex, uv, count = 0, 0, 0, vertices
        while parts < 3 and not (parts == 2 and _KINDS[text[at]] != _WORD):
            index, at = _index(text, at, count)
            if at < 0:
                return -1
            if parts == 0:
                vertex, count = index, uvs
            elif parts == 1:
                # Normals are of no use here, and may count from the end of a list of any length.
                uv, count = index, _NORMALS
            parts += 1
            if text[at] != _SLASH or parts == 3:
                break
            at += 1
        if parts < 2 or _KINDS[text[at]] == _WORD or (alike > 0 and alike != parts):
            return -1
        alike = parts
        corners[corner, 0], corners[corner, 1] = vertex, uv
        corner += 1
        at = _skip_blanks(text, at)
    if corner < counts[CORNERS] + 3:
        return -1
    counts[CORNERS] = corner
    faces[counts[FACES], 0], faces[counts[FACES], 1] = corner, begin
    counts[FACES] += 1
    return at


@inner()
def _index(text: NDArray[np.uint8], at: int, count: int) -> tuple[int, int]:
    """The index at ``at``, from 0, in a list of ``count`` so far; and where it ends, or -1."""
    backwards = text[at] == _MINUS
    at += backwards
    value, begin = 0, at
    digit = text[at] - _ZERO
    while 0 <= digit <= 9:
        value = 10 * value + digit
        at += 1
        digit = text[at] - _ZERO
    if value == 0 or at - begin > _INDEX_DIGITS or (backwards and value > count):
        return 0, -1
    return count - value if backwards else value - 1, at


@inner()
def _skip_blanks(text: NDArray[np.uint8], at: int) -> int:
    while _KINDS[text[at]] == _BLANK:
        at += 1
    return at
