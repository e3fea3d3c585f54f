"""Scans made clean in up to three steps, each of which says what it did and leaves alone what needs nothing."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

from facezip.character.alignment import alignments, worst_of
from facezip.character.notes import Note, say
from facezip.character.registration import register
from facezip.character.scans import NEUTRAL, Character
from facezip.cleaning.exposure import even_out
from facezip.cleaning.neutral import fused
from facezip.machine.progress import track

# In the order in which they are taken: each needs those before it to have been needless or done.
STEPS = ("registration", "exposure", "neutral")


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Scans without what a capture added.

    Attributes
    ----------
    character : with a note for each change.
    facts : by step what it did, as documents state it; empty where there was none to take.
    """

    character: Character
    facts: dict[str, Any]


def clean(character: Character, steps: Collection[str] = STEPS) -> Cleaned:
    """Take those of :data:`STEPS` that are asked for, in their order.

    ``registration`` moves textures onto the neutral's (:mod:`facezip.character.registration`), ``exposure`` evens out
    light and white balance (:mod:`facezip.cleaning.exposure`), ``neutral`` makes the neutral of all scans
    (:mod:`facezip.cleaning.neutral`). Meshes stay.
    """
    facts: dict[str, Any] = {}
    before = len(character.notes)
    for step in STEPS:
        if step in steps:
            character, facts[step] = _TAKE[step](character)
    say(character.name, character.notes[before:])
    return Cleaned(character, facts)


def _registered(character: Character) -> tuple[Character, dict[str, Any]]:
    found = alignments(character)
    registered, moved = register(character, found)
    off = {name: round(worst_of(found[name]).rms, 3) for name in moved}
    return _noted(registered, moved, "moved onto the neutral's texture"), {"moved": off}


def _evened(character: Character) -> tuple[Character, dict[str, Any]]:
    evened, gains = even_out(character)
    return _noted(evened, gains, "exposure and white balance evened out"), {"gains": gains}


def _fused(character: Character) -> tuple[Character, dict[str, Any]]:
    stacks, facts, changed = dict(character.stacks), {}, []
    for (name, tile), stack in track(character.stacks.items(), "Making the neutral", len(character.stacks)):
        made = fused(stack)
        stacks[name, tile] = made.stack
        facts[f"{name}.{tile}"] = {
            "noise": round(made.noise, 3),
            "scans": round(made.scans, 1),
            "removed": round(made.removed, 3),
        }
        changed += [] if made.stack is stack else [f"{NEUTRAL} {name}" if name != character.maps[0].name else NEUTRAL]
    better = replace(character, stacks=stacks)
    return _noted(better, dict.fromkeys(changed), "made of all scans, whose lost detail came from it"), facts


def _noted(character: Character, names: Collection[str], words: str) -> Character:
    return replace(character, notes=(*character.notes, *(Note(name, words) for name in names)))


_TAKE = {"registration": _registered, "exposure": _evened, "neutral": _fused}
