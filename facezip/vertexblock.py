"""The vertices of an OBJ file at once, where its ``v`` lines lie together as every exporter writes them.

Reading line by line takes most of the time of loading a character. What is unusual in the least is left to that.
"""

import numpy as np
from numpy.typing import NDArray

# All that the keyword, decimal numbers and white space are made of.
_PLAIN = b"v0123456789+-.eE \t\r\n"
_NEWLINE, _SPACE = b"\n "


def split_vertices(text: bytes) -> tuple[NDArray[np.float64], bytes] | None:
    """The first three numbers of every ``v`` line ``(V, 3)``, and the text after these lines; None if unusual."""
    begin = 0 if text.startswith(b"v ") else text.find(b"\nv ") + 1
    if text[begin : begin + 2] != b"v ":
        return None
    end = _end(text, begin)
    block, rest = text[begin:end], text[end:]
    lone_returns = text.count(b"\r") != text.count(b"\r\n")
    if block.translate(None, _PLAIN) or lone_returns or b"\nv " in rest:
        return None
    count, columns = _table(block)
    if columns < 4:
        return None
    try:
        values = np.fromstring(block.replace(b"v", b""), sep=" ")
    except (ValueError, DeprecationWarning):
        return None
    return (values.reshape(count, columns - 1)[:, :3], rest) if values.size == count * (columns - 1) else None


def _end(text: bytes, begin: int) -> int:
    """Where the ``v`` lines end that begin at ``begin``."""
    newlines = np.flatnonzero(np.frombuffer(text, np.uint8, offset=begin)[:-2] == _NEWLINE) + begin
    characters = np.frombuffer(text, np.uint8)
    last = newlines[(characters[newlines + 1] != ord("v")) | (characters[newlines + 2] != _SPACE)]
    return int(last[0]) + 1 if len(last) else len(text)


def _table(block: bytes) -> tuple[int, int]:
    """Lines, and words of each; 0 words where lines differ, or hold ``v`` elsewhere than at their beginning."""
    lines = block.count(b"\n") + (not block.endswith(b"\n"))
    blank = np.frombuffer(block, np.uint8) <= _SPACE
    starts = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    if lines == 0 or len(starts) % lines or block.count(b"v") != lines:
        return lines, 0
    columns = len(starts) // lines
    firsts = starts.reshape(lines, columns)[:, 0]
    # As many words as lines have: every line begins with the word that it should.
    regular = (np.frombuffer(block, np.uint8)[firsts] == ord("v")).all()
    return lines, columns if regular else 0
