"""Names come from file systems, packs and people: which ones are safe to write, and how all of them are shown."""

import re
import unicodedata
from collections.abc import Iterable

MAX_CHARACTERS = 128
# Leaves room for a suffix and a temporary name in the 255 bytes of common file systems.
MAX_BYTES = 200

_FORBIDDEN = re.compile(r"[/\\:]")
_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}
# A character folder gives these a meaning.
_RESERVED = {"neutral", "mask"}


def is_safe_name(name: str) -> bool:
    """Whether an expression's name can serve as a file name on every system, inside the folder that it is put in."""
    return (
        0 < len(name) <= MAX_CHARACTERS
        and name.isprintable()
        and len(name.encode()) <= MAX_BYTES
        and not _FORBIDDEN.search(name)
        and not name.startswith(".")
        and not name.endswith(".")
        and name == name.strip()
        and name.casefold() not in _RESERVED
        and name.split(".")[0].strip().casefold() not in _DEVICES
    )


def one_form(name: str) -> str:
    """A name in the form of Unicode in which all names are kept (NFC): systems write the same one in several."""
    return unicodedata.normalize("NFC", name)


def folded(name: str) -> str:
    """What names are compared as: the same for those that a file system may take for one."""
    return one_form(one_form(name).casefold())


def first_unusable(names: Iterable[str]) -> str | None:
    """The first of the expressions' names that is unsafe, or that a file system may take for an earlier one."""
    seen: set[str] = set()
    for name in names:
        key = folded(name) if is_safe_name(name) else ""
        if not key or key in seen:
            return name
        seen.add(key)
    return None


def printable(text: str) -> str:
    """``text`` on one line, without anything that a terminal would obey: what cannot be shown is escaped."""
    return "".join(c if _can_be_shown(c) else c.encode("unicode_escape").decode("ascii") for c in text)


def _can_be_shown(character: str) -> bool:
    """Spaces too, of which there are several: our own sentences keep figures and their units on one line."""
    return character.isprintable() or unicodedata.category(character) == "Zs"
