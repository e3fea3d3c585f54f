"""Names of references: of a test's image, of one platform or variant, and of another look that is accepted as well.

``STEM.exr`` is the reference of an image. ``STEM@linux.exr`` or ``STEM@scalar_rgb.exr`` stands in its place on one
platform or under one variant, ``STEM+NAME.exr`` beside it: an image passes if it agrees with one of them.
"""

import re
import sys
from collections.abc import Iterable

from facezip.errors import ErrorCode, FaceZipError

# No stem has one of these characters.
INSTEAD, BESIDE = "@", "+"
PLATFORM = "platform"
VARIANT = "variant"
_NAME = re.compile(r"[A-Za-z0-9_.-]+")


def stem_of(name: str) -> str:
    """The image that a reference is of."""
    return re.split(r"[@+]", name, maxsplit=1)[0]


def accepted(names: Iterable[str], stem: str, variant: str) -> list[str]:
    """Which of the references ``names`` an image may agree with; the first is the one that it usually has.

    Parameters
    ----------
    names : of the references that there are, without suffixes.
    stem : of the image.
    variant : that it was made under, or "".
    """
    own = [name for name in names if stem_of(name) == stem]
    places = [f"{stem}{INSTEAD}{place}" for place in (variant, sys.platform) if place] + [stem]
    mains = {name.partition(BESIDE)[0] for name in own}
    main = next((place for place in places if place in mains), stem)
    return sorted((name for name in own if name.partition(BESIDE)[0] == main), key=lambda name: (name != main, name))


def labelled(usual: str, label: str, variant: str) -> str:
    """The name to write a reference under, where ``usual`` is the one that the image has or would have.

    The labels ``platform`` and ``variant`` stand for this one, and instead of the usual reference; others beside it.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE``: the image has no variant.
    """
    if label in (PLATFORM, VARIANT):
        place = sys.platform if label == PLATFORM else variant
        if not place:
            raise FaceZipError(ErrorCode.BAD_VALUE, "the image has no variant; give facezip_image one with variant=")
        return f"{stem_of(usual)}{INSTEAD}{place}"
    return f"{usual.partition(BESIDE)[0]}{BESIDE}{label}" if label else usual


def is_label(label: str) -> bool:
    """Whether it can be part of a file's name."""
    return bool(_NAME.fullmatch(label))
