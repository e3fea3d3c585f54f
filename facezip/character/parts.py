"""Which part of a character is the face, where files have several: head, eyes, teeth."""

import re
from collections.abc import Iterable, Sequence

from facezip.names import folded

_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
_SIDE = r"(?:left|right|upper|lower|inner|outer|[lr])?"
# Words of names that no face is called by.
_INNER = re.compile(
    _SIDE + r"(?:eye(?:ball|brow|lash|lashe|lid|wet|shadow|occlusion)?|brow|lash|lashe|lens|lense|pupil|iris|sclera|"
    r"cornea|tear|tearline|occlusion|tooth|teeth|gum|tongue|mouth|jaw|dental|enamel|hair|scalp|beard|moustache|body|torso|neck|"
    r"arm|leg|hand|foot|feet|nail|finger|cloth|clothe|clothing|shirt|outfit|glasse|hat|cap|collar|shoe)s?" + _SIDE
)
SHOWN = 8


def is_called(name: str, labels: Iterable[str]) -> bool:
    """Whether a name is one of some, but for case and the form of Unicode."""
    return folded(name) in map(folded, labels)


def without_inner(parts: Sequence[Sequence[str]]) -> list[int]:
    """Numbers of the parts none of whose labels says that it lies in, on or below the face."""
    return [number for number, labels in enumerate(parts) if not any(map(_is_inner, labels))]


def _is_inner(label: str) -> bool:
    words = [word.casefold() for word in _WORD.findall(label)]
    return any(_INNER.fullmatch(word) for word in words)


def listed(names: Iterable[str]) -> str:
    """Names in quotes; the first few of many."""
    every = [f"'{name[:64]}'" for name in names]
    more = len(every) - SHOWN
    return ", ".join(every[:SHOWN]) + (f" and {more} more" if more > 0 else "")
