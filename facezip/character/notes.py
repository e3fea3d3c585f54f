"""What a character's files say that is not ordinary, what was therefore done, and what is not used."""

import logging
from collections.abc import Iterable
from dataclasses import dataclass

# A program that uses the library hears it as its own log says; the command line prints it.
_log = logging.getLogger("facezip")


@dataclass(frozen=True)
class Note:
    """One sentence on one file.

    Attributes
    ----------
    file : its name, relative to the character's folder.
    words : what was done or left out, such as ``converted from Display P3 to sRGB``.
    asks : whether a person should decide, because the files can be meant in two ways.
    """

    file: str
    words: str
    asks: bool = False


def lines(notes: Iterable[Note]) -> list[str]:
    """Notes as lines, one for all files of which the same is said."""
    files: dict[str, list[str]] = {}
    for note in notes:
        files.setdefault(note.words, []).append(note.file)
    return [
        f"{names[0]}{f' and {more} more' if (more := len(names) - 1) else ''}: {words}"
        for words, names in files.items()
    ]


def say(name: str, notes: Iterable[Note]) -> None:
    """Log notes on the character of that name, as warnings."""
    for line in lines(notes):
        _log.warning("%s: %s", name, line)
