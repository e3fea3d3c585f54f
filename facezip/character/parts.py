"""Which part of a character is the face, where files have several: head, eyes, teeth."""

import re
from collections.abc import Iterable, Sequence

from facezip.names import folded

# Whole words of names, or words run together with others in capitals, that no face is called by.
_INNER = re.compile(
    r"eye|brow|lash|lid|lens|pupil|iris|sclera|cornea|tear|occlu|tooth|teeth|gum|tongue|mouth|jaw|dent|enamel|hair|scalp|"
    r"beard|moustache|body|torso|arm|leg|hand|foot|nail|cloth|shirt|outfit|glass|hat|cap",
    re.IGNORECASE,
)
SHOWN = 8


def is_called(name: str, labels: Iterable[str]) -> bool:
    """Whether a name is one of some, but for case and the form of Unicode."""
    return folded(name) in map(folded, labels)


def without_inner(parts: Sequence[Sequence[str]]) -> list[int]:
    """Numbers of the parts none of whose labels says that it lies in, on or below the face."""
    return [number for number, labels in enumerate(parts) if not any(map(_INNER.search, labels))]


def listed(names: Iterable[str]) -> str:
    """Names in quotes; the first few of many."""
    every = [f"'{name[:64]}'" for name in names]
    more = len(every) - SHOWN
    return ", ".join(every[:SHOWN]) + (f" and {more} more" if more > 0 else "")
