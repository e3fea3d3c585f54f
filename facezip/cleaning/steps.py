"""Scans made clean in up to three steps, each of which says what it did and leaves alone what needs nothing."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from facezip.character.alignment import alignments, worst_of
from facezip.character.notes import Note, say
from facezip.character.registration import register
from facezip.character.scans import NEUTRAL, Character
from facezip.cleaning.exposure import even_out
from facezip.cleaning.neutral import fused
from facezip.machine.progress import track

# In the order in which they are taken: each needs those before it to have been needless or done.
STEPS = ("registration", "exposure", "neutral")


@dataclass(frozen=True, kw_only=True)
class MovedFacts:
    """Textures that were moved onto the neutral's.

    Attributes
    ----------
    moved : by expression how far, the root mean square in texels.
    """

    moved: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class ExposureFacts:
    """Textures whose light and white balance were evened out.

    Attributes
    ----------
    gains : by expression, those of the channels.
    """

    gains: Mapping[str, Sequence[float]]


@dataclass(frozen=True, kw_only=True)
class NeutralFacts:
    """A neutral that was made of all scans.

    Attributes
    ----------
    noise : its standard deviation, of 255.
    scans : how many scans' worth went into it; 0 where it was left as it is.
    removed : how much was changed, of 255.
    """

    noise: float
    scans: float
    removed: float


@dataclass(frozen=True, kw_only=True)
class CleaningFacts:
    """What ``--clean`` did, by step.

    Attributes
    ----------
    registration, exposure : of those two steps, where they were taken.
    neutral : by ``MAP.TILE``, where that step was taken.
    """

    registration: MovedFacts | None = None
    exposure: ExposureFacts | None = None
    neutral: Mapping[str, NeutralFacts] | None = None


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Scans without what a capture added.

    Attributes
    ----------
    character : with a note for each change.
    facts : what the steps did.
    """

    character: Character
    facts: CleaningFacts


def clean(character: Character, steps: Collection[str] = STEPS) -> Cleaned:
    """Take those of :data:`STEPS` that are asked for, in their order.

    ``registration`` moves textures onto the neutral's (:mod:`facezip.character.registration`), ``exposure`` evens out
    light and white balance (:mod:`facezip.cleaning.exposure`), ``neutral`` makes the neutral of all scans
    (:mod:`facezip.cleaning.neutral`). Meshes stay.
    """
    facts = CleaningFacts()
    before = len(character.notes)
    for step in STEPS:
        if step in steps:
            character, facts = _TAKE[step](character, facts)
    say(character.name, character.notes[before:])
    return Cleaned(character, facts)


def _registered(character: Character, facts: CleaningFacts) -> tuple[Character, CleaningFacts]:
    found = alignments(character)
    registered, moved = register(character, found)
    off = {name: round(worst_of(found[name]).rms, 3) for name in moved}
    facts = replace(facts, registration=MovedFacts(moved=off))
    return _noted(registered, moved, "moved onto the neutral's texture"), facts


def _evened(character: Character, facts: CleaningFacts) -> tuple[Character, CleaningFacts]:
    evened, gains = even_out(character)
    facts = replace(facts, exposure=ExposureFacts(gains=gains))
    return _noted(evened, gains, "exposure and white balance evened out"), facts


def _fused(character: Character, facts: CleaningFacts) -> tuple[Character, CleaningFacts]:
    stacks, neutrals, changed = dict(character.stacks), dict[str, NeutralFacts](), []
    for (name, tile), stack in track(character.stacks.items(), "Making the neutral", len(character.stacks)):
        made = fused(stack)
        stacks[name, tile] = made.stack
        neutrals[f"{name}.{tile}"] = NeutralFacts(
            noise=round(made.noise, 3), scans=round(made.scans, 1), removed=round(made.removed, 3)
        )
        changed += [] if made.stack is stack else [f"{NEUTRAL} {name}" if name != character.maps[0].name else NEUTRAL]
    better = replace(character, stacks=stacks)
    words = "made of all scans, whose lost detail came from it"
    return _noted(better, dict.fromkeys(changed), words), replace(facts, neutral=neutrals)


def _noted(character: Character, names: Collection[str], words: str) -> Character:
    return replace(character, notes=(*character.notes, *(Note(name, words) for name in names)))


_TAKE = {"registration": _registered, "exposure": _evened, "neutral": _fused}
