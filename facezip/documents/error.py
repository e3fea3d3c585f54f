"""Why something was not done, as documents say it."""

from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document
from facezip.errors import FaceZipError


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Why something was not done.

    Attributes
    ----------
    code : of the error; stable.
    message : the sentence for a person.
    """

    code: str
    message: str

    @classmethod
    def of(cls, error: FaceZipError) -> "Fault":
        """That of an error."""
        return cls(code=str(error.code), message=str(error))


@dataclass(frozen=True, kw_only=True)
class ErrorDocument(Document):
    """What a verb answers that could not do its work.

    Attributes
    ----------
    error : why.
    """

    format: Literal["facezip-error/1"] = "facezip-error/1"
    error: Fault
