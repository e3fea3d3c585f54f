"""The pictures of an animation: frames cropped alike, a loop side by side, a contact sheet."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from render.paired import Images
from reports.images import BACKDROP, ColourScale, Crop, data_uri, difference, display, to_bytes

# Milliseconds of a frame, and WebP qualities of the loop and of stills.
PERIOD = 90
LOOP_QUALITY, STILL_QUALITY = 80, 88
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Reel:
    """Displayed frames, all cropped alike.

    Attributes
    ----------
    originals, compressed, differences : T pictures ``(h, w, 3)`` of 8 bits; differences in the scale's colours.
    scale : of the differences.
    """

    originals: list[Pixels]
    compressed: list[Pixels]
    differences: list[Pixels]
    scale: ColourScale

    @classmethod
    def of(cls, images: Sequence[Images]) -> "Reel":
        """The frames as a display shows them; one scale for all, by the worst."""
        crop = Crop.around([one.coverage for one in images])
        shown = [[display(_premultiplied(crop, one, k)) for k in (0, 1)] for one in images]
        gaps = [difference(*pair) for pair in shown]
        heads = [crop.of(one.coverage) for one in images]
        errors = (np.sqrt(np.mean(np.square(gap[head > 0]))) for gap, head in zip(gaps, heads, strict=True))
        scale = ColourScale.for_error(max(float(error) for error in errors))
        colours = [scale.colours(gap) for gap in gaps]
        for picture, head in zip(colours, heads, strict=True):
            picture[head == 0] = BACKDROP
        return cls([to_bytes(a) for a, _ in shown], [to_bytes(b) for _, b in shown], colours, scale)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of a frame side by side."""
        height, width, _ = self.side_by_side(0).shape
        return width, height

    def side_by_side(self, frame: int) -> Pixels:
        """Original, compressed and difference of a frame, from left to right."""
        return np.concatenate([part[frame] for part in (self.originals, self.compressed, self.differences)], axis=1)

    def uri(self, frame: int) -> str:
        """A frame side by side as a data URI."""
        return data_uri(self.side_by_side(frame), STILL_QUALITY)


def _premultiplied(crop: Crop, images: Images, k: int) -> NDArray[np.float32]:
    return crop.of(np.concatenate([images.linear[k], images.coverage[:, :, None]], axis=2))


def moving(reel: Reel) -> bytes:
    """The frames side by side as an animated WebP that loops."""
    first, *others = (Image.fromarray(reel.side_by_side(t)) for t in range(len(reel.originals)))
    file = BytesIO()
    options = {"save_all": True, "append_images": others, "duration": PERIOD, "loop": 0}
    first.save(file, "webp", quality=LOOP_QUALITY, method=2, **options)
    return file.getvalue()


def sheet(reel: Reel, frames: Sequence[int]) -> str:
    """A contact sheet as a data URI: one column a frame; original, compressed and difference below each other."""
    rows = [np.concatenate([part[t] for t in frames], axis=1) for part in _parts(reel)]
    return data_uri(np.concatenate(rows, axis=0), STILL_QUALITY)


def _parts(reel: Reel) -> tuple[list[Pixels], list[Pixels], list[Pixels]]:
    return reel.originals, reel.compressed, reel.differences
