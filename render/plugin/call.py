"""One call of the fixture: an image, and how it is to be compared."""

from dataclasses import dataclass
from typing import Any

from render.plugin.ignoring import Region
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

    @property
    def told(self) -> dict[str, Any]:
        """What a result says of it."""
        more = {"variant": self.variant} if self.variant else {}
        return {"name": self.name, **more, **({"must_differ": True} if self.must_differ else {})}
