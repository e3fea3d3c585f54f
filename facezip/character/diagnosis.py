"""What is found in a folder or file without using it: a table of what is read from where, and what to do."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

from facezip.character.notes import Note
from facezip.documents.document import Document
from facezip.errors import FaceZipError


@dataclass(frozen=True)
class Row:
    """One file, or one thing in a file.

    Attributes
    ----------
    file : its name, relative to the folder.
    what : what is read from it: ``mesh``, ``mask``, the name of a map, or what else it is.
    whose : of which expression, or ``neutral``; "" where that says nothing.
    tile : the UDIM number; None for what is of no tile.
    encoding : how its numbers are stored, such as ``PNG, uint8, 3 channels, sRGB``.
    orientation : how it lies: ``as stored``, or by what it is turned.
    size : ``1024x1024``, or numbers of vertices and triangles.
    unit : what one of its numbers is; "" where it has none.
    """

    file: str
    what: str
    whose: str
    tile: int | None
    encoding: str = ""
    orientation: str = ""
    size: str = ""
    unit: str = ""


@dataclass(frozen=True)
class Refusal:
    """Why something cannot be used: the code and the sentence of an error."""

    code: str
    words: str

    @classmethod
    def of(cls, error: FaceZipError) -> "Refusal":
        """That of an error."""
        return cls(str(error.code), str(error))


@dataclass(frozen=True)
class Diagnosis(Document):
    """All of it, as ``facezip doctor`` says it.

    Attributes
    ----------
    kind : ``character``, ``pack`` or ``export``.
    path : of what, as it was given.
    summary : what it is, in one line.
    rows : what is read from where.
    refusals : what has to be mended before it can be used: all that can be found at once.
    notes : what is unusual, missing or not used; those that ask need a decision.
    character_toml : where the files of a character could not be told, a ``character.toml`` to complete; "" otherwise.
    asks : whether a person should decide something.
    """

    format: Literal["facezip-doctor/1"] = field(default="facezip-doctor/1", kw_only=True)
    kind: str
    path: str
    summary: str
    rows: tuple[Row, ...] = ()
    refusals: tuple[Refusal, ...] = ()
    notes: tuple[Note, ...] = ()
    character_toml: str = ""
    asks: bool = field(init=False)

    def __post_init__(self) -> None:
        """What asks is told by the notes."""
        object.__setattr__(self, "asks", any(note.asks for note in self.notes))


def distinct(errors: Iterable[FaceZipError]) -> tuple[Refusal, ...]:
    """Errors, each once."""
    return tuple(dict.fromkeys(map(Refusal.of, errors)))
