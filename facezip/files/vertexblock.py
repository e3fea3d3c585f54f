"""The vertices of an OBJ file at once, where its ``v`` lines lie together as every exporter writes them.

Reading line by line takes most of the time of loading a character, and keeps other threads from reading theirs. What is
unusual in the least is left to that.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

_V, _E, _ZERO, _NINE, _PLUS, _MINUS, _POINT = b"ve09+-."
_SPACE, _TAB, _NEWLINE, _RETURN = b" \t\n\r"
# Digits that an integer of 64 bits holds whatever they are.
_DIGITS = 18
# Exactly, up to the 22nd; numbers of up to 15 digits are then read to the last bit of a float64.
_POWERS = 10.0 ** np.arange(64)


def split_vertices(text: bytes) -> tuple[NDArray[np.float64], bytes] | None:
    """The first three numbers of every ``v`` line ``(V, 3)``, and the text beside these lines; None if unusual."""
    begin = 0 if text.startswith(b"v ") else text.find(b"\nv ") + 1
    values = np.empty((text.count(b"\nv ") + 1, 3))
    count, end = _parse(np.frombuffer(text, np.uint8), begin, values)
    if count < 1 or b"\nv " in text[end - 1 :] or b"\rv " in text:
        return None
    return values[:count], text[:begin] + text[end:]


@njit(cache=True, nogil=True)
def _parse(text: NDArray[np.uint8], begin: int, out: NDArray[np.float64]) -> tuple[int, int]:
    """How many lines in a row are vertices, -1 if one of them is unusual, and where the next line begins."""
    at, row = begin, 0
    while at + 1 < len(text) and text[at] == _V and text[at + 1] == _SPACE:
        at += 1
        for column in range(3):
            while at < len(text) and (text[at] == _SPACE or text[at] == _TAB):
                at += 1
            out[row, column], at = _number(text, at)
            if at < 0:
                return -1, 0
        while at < len(text) and text[at] != _NEWLINE:
            if text[at] == _RETURN and at + 1 < len(text) and text[at + 1] != _NEWLINE:
                return -1, 0
            at += 1
        at += 1
        row += 1
    return row, min(at, len(text))


@njit(cache=True, nogil=True)
def _number(text: NDArray[np.uint8], at: int) -> tuple[float, int]:
    """The decimal number at ``at``, and where it ends; -1 where it is none, or too long, or does not end there."""
    negative, at = _sign(text, at)
    mantissa, digits, at = _digits(text, at)
    exponent = 0
    if at < len(text) and text[at] == _POINT:
        fraction, places, at = _digits(text, at + 1)
        digits, exponent = digits + places, -places
        if digits <= _DIGITS:
            mantissa = mantissa * 10**places + fraction
    if digits == 0 or digits > _DIGITS:
        return 0.0, -1
    if at < len(text) and text[at] | 0x20 == _E:
        below, at = _sign(text, at + 1)
        power, places, at = _digits(text, at)
        if places == 0 or places > 3:
            return 0.0, -1
        exponent += -power if below else power
    if abs(exponent) >= len(_POWERS) or (at < len(text) and text[at] > _SPACE):
        return 0.0, -1
    value = mantissa * _POWERS[exponent] if exponent >= 0 else mantissa / _POWERS[-exponent]
    return -value if negative else value, at


@njit(cache=True, nogil=True)
def _sign(text: NDArray[np.uint8], at: int) -> tuple[bool, int]:
    if at < len(text) and (text[at] == _PLUS or text[at] == _MINUS):
        return text[at] == _MINUS, at + 1
    return False, at


@njit(cache=True, nogil=True)
def _digits(text: NDArray[np.uint8], at: int) -> tuple[int, int, int]:
    """The integer that begins at ``at``, how many digits it has, and where it ends."""
    value, begin = 0, at
    while at < len(text) and _ZERO <= text[at] <= _NINE:
        if at - begin < _DIGITS:
            value = 10 * value + (text[at] - _ZERO)
        at += 1
    return value, at - begin, at
