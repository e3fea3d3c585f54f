"""What a run of image tests found: as workers send it, as ``results.json`` has it, and as pages show it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document

Outcome = Literal["failed", "warned", "generated", "passed"]
Change = Literal["new", "added", "changed", "same"]


@dataclass(frozen=True, kw_only=True)
class Place:
    """The block of pixels in which an image and its reference differ most.

    Attributes
    ----------
    row, column : of its upper left pixel.
    side : in pixels.
    image, reference : means over it, in the channel that tells most.
    deviations : their difference in standard errors.
    """

    row: int
    column: int
    side: int
    image: float
    reference: float
    deviations: float


@dataclass(frozen=True, kw_only=True)
class Compared:
    """An image against the accepted reference that it is most like.

    Attributes
    ----------
    probability : that noise alone differs as much.
    statistic : the one that is least likely: largest or sum, and the side of its blocks in pixels.
    renders : independent renders of the image.
    accepted : how many references are accepted.
    place : where both differ most.
    """

    probability: float
    statistic: str
    renders: int
    accepted: int
    place: Place


@dataclass(frozen=True, kw_only=True)
class Written:
    """A reference that was written.

    Attributes
    ----------
    change : new; added beside or instead of others that stay; changed; or the same as before.
    renders : independent renders in it.
    before : sha256 of the image that was there, where it could be read and is another.
    after : sha256 of the image that is there now.
    """

    change: Change
    renders: int
    before: str | None = None
    after: str


@dataclass(frozen=True, kw_only=True)
class Result:
    """What became of one image.

    Attributes
    ----------
    name : of the image and its evidence, different for every one of a run.
    test : node id of the test.
    variant : that the image was made under, where the test says it.
    must_differ : whether it was spoilt on purpose, and fails where it agrees.
    outcome : what the test made of it; a warning passes.
    level : probability below which the two differ.
    reference : its file, where the test came so far.
    comparison : with it; of an image whose reference was written, with what was there before.
    written : its reference, where that was written.
    evidence : the folder of its pictures, where there is one.
    message : what a failure says.
    """

    name: str
    test: str
    variant: str | None = None
    must_differ: bool
    outcome: Outcome
    level: float
    reference: str | None = None
    comparison: Compared | None = None
    written: Written | None = None
    evidence: str | None = None
    message: str | None = None

    @property
    def differs(self) -> bool:
        """Whether it is known to differ from its reference by more than noise."""
        return self.comparison is not None and self.comparison.probability < self.level


@dataclass(frozen=True, kw_only=True)
class StaleReference:
    """A reference without a test.

    Attributes
    ----------
    reference : its file.
    test : node id of the test that made it; empty where several shared it.
    """

    reference: str
    test: str


@dataclass(frozen=True, kw_only=True)
class ImagesDocument(Document):
    """The image tests of one run of pytest.

    Attributes
    ----------
    results : of every image, by name.
    stale : references without a test.
    idle : how many tests ask for images, where none compared any; else 0.
    """

    format: Literal["facezip-images/2"] = "facezip-images/2"
    results: Sequence[Result]
    stale: Sequence[StaleReference]
    idle: int
