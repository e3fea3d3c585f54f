"""One call of the fixture: an image, and how it is to be compared."""

from dataclasses import dataclass

from render.plugin.ignoring import Region
from render.plugin.results import Result
from render.plugin.sources import Source


@dataclass(frozen=True, eq=False)
class Call:
    """What a test hands over.

    Attributes
    ----------
    name : of the result and its evidence, different for every call.
    stem : of its reference; ``shared`` where other tests may have the same.
    source, variant, spp, renders, reference_renders, level, warn, ignore, must_differ : as in
        :class:`render.plugin.fixture.ImageCheck`.
    """

    name: str
    stem: str
    shared: bool
    source: Source
    variant: str
    spp: int
    renders: int
    reference_renders: int
    level: float
    warn: float
    ignore: Region
    must_differ: bool

    def result(self, test: str) -> Result:
        """What is said of it for a test, by its node id, as long as nothing is wrong."""
        return Result(
            name=self.name,
            test=test,
            variant=self.variant or None,
            must_differ=self.must_differ,
            outcome="passed",
            level=self.level,
        )
