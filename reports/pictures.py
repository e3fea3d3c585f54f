"""The pictures of a validation: every render and every pack's difference, cropped and encoded to be embedded."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.documents.document import Data
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.progress import track
from render.exr import read_exr
from reports.images import BACKDROP, ColourScale, Crop, data_uri, difference, display, read_coverage, to_bytes

WORKERS = 2


@dataclass(frozen=True)
class Quality:
    """How pictures are embedded: WebP quality 0..100, lossless where None."""

    picture: int | None
    difference: int | None


HERO = Quality(None, None)
WORST = Quality(92, 88)
OTHER = Quality(78, 70)


@dataclass(frozen=True)
class Pictures:
    """Data URIs of one render; ``compressed`` and ``differences`` are in the order of the packs."""

    original: str
    compressed: tuple[str, ...]
    differences: tuple[str, ...]
    size: tuple[int, int]


def crops(renders: Sequence[Data], folder: Path) -> dict[str, Crop]:
    """One crop a view, which holds the head in every expression: pictures of a view can be compared by position."""
    with ThreadPoolExecutor(WORKERS) as pool:
        reading = pool.map(lambda render: read_coverage(folder / render["exr"]), renders)
        coverages = list(track(reading, "Framing the renders", len(renders)))
    views = dict.fromkeys(render["view"] for render in renders)
    return {
        view: Crop.around([seen for render, seen in zip(renders, coverages, strict=True) if render["view"] == view])
        for view in views
    }


def embed(jobs: Sequence[tuple[Data, Quality]], folder: Path, packs: int, scale: ColourScale) -> list[Pictures]:
    """Encode renders of a document, each with its quality; raises what :func:`render.exr.read_exr` raises."""
    frames = crops([render for render, _ in jobs], folder)

    def one(job: tuple[Data, Quality]) -> Pictures:
        render, quality = job
        return _pictures(folder / render["exr"], frames[render["view"]], packs, scale, quality)

    with ThreadPoolExecutor(WORKERS) as pool:
        return list(track(pool.map(one, jobs), "Embedding pictures", len(jobs)))


def _pictures(path: Path, crop: Crop, packs: int, scale: ColourScale, quality: Quality) -> Pictures:
    parts = [crop.of(part) for part in read_exr(path).values()]
    if len(parts) != packs + 1:
        raise FaceZipError(
            ErrorCode.UNREADABLE_IMAGE, f"{path}: {len(parts)} parts for an original and {packs} packs; validate again"
        )
    shown = [display(part) for part in parts]
    maps = [_difference_map(shown[0], other, parts[0][..., 3], scale) for other in shown[1:]]
    return Pictures(
        original=data_uri(to_bytes(shown[0]), quality.picture),
        compressed=tuple(data_uri(to_bytes(other), quality.picture) for other in shown[1:]),
        differences=tuple(data_uri(colours, quality.difference) for colours in maps),
        size=crop.size,
    )


def _difference_map(
    original: NDArray[np.float32], compressed: NDArray[np.float32], coverage: NDArray[np.float32], scale: ColourScale
) -> NDArray[np.uint8]:
    """The difference in colours, on the backdrop where there is no head: no difference looks unlike no head."""
    colours = scale.colours(difference(original, compressed))
    colours[coverage == 0] = BACKDROP
    return colours
