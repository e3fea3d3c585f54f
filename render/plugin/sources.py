"""What a test hands over, as independent renders: a scene, a function of the seed, or images."""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float

Source = Mapping[str, Any] | Callable[[int], Any] | Sequence[Any] | Any


def renders_of(source: Source, seeds: range, spp: int) -> NDArray[np.float32]:
    """``(n, H, W, C)`` renders, C 3 or 4; grey images get three equal channels.

    Parameters
    ----------
    source : a Mitsuba scene, as a dict or loaded, a function from a seed to an image, one image, or a list of images.
    seeds : of the renders; a source of images has as many as it has.
    spp : samples per pixel of a scene.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for what is no image, ``BAD_TEXELS`` for values that are not finite, ``SIZE_MISMATCH`` for images
        of other shapes; what :func:`scene_renderer` raises.
    """
    if is_scene(source):
        source = scene_renderer(source, spp)
    if callable(source):
        images = [_image(source(seed)) for seed in seeds]
    else:
        images = [_image(one) for one in (source if isinstance(source, list | tuple) else [source])]
    if len({image.shape for image in images}) != 1:
        sizes = ", ".join(sorted({_size(image) for image in images})) or "no image at all"
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"independent renders of one image have one size, not {sizes}")
    return np.stack(images)


def scene_renderer(scene: Any, spp: int) -> Callable[[int], NDArray[np.float32]]:
    """A function that renders a Mitsuba scene with a seed, by the scene's own integrator.

    A variant that is set already stays; otherwise it is FaceZip's.

    Parameters
    ----------
    scene : a dict, or a scene loaded under the variant that is set.
    spp : samples per pixel.

    Raises
    ------
    FaceZipError
        ``NO_LLVM`` where Dr.Jit would abort, ``BAD_VALUE`` for a scene that was loaded under another variant.
    """
    from render.llvm import check_loaded, start

    variant = sys.modules["mitsuba"].variant() if "mitsuba" in sys.modules else None
    if variant is None:
        start()
    elif variant.startswith("llvm"):
        check_loaded()
    import mitsuba as mi

    loaded = mi.load_dict(dict(scene)) if isinstance(scene, Mapping) else scene
    if not isinstance(loaded, mi.Scene):
        reason = f"the scene was loaded under another variant than '{mi.variant()}', which is set"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{reason}; hand over the dict that it was loaded from")
    return lambda seed: np.array(mi.render(loaded, seed=seed, spp=spp))


def is_scene(source: Any) -> bool:
    """Whether it is a Mitsuba scene, as a dict or loaded under any variant."""
    kinds = [(kind.__module__.partition(".")[0], kind.__name__) for kind in type(source).__mro__]
    return isinstance(source, Mapping) or ("mitsuba", "Scene") in kinds


def _image(values: Any) -> NDArray[np.float32]:
    texels = np.asarray(values)
    if texels.dtype.kind not in "biuf":
        reason = f"an image is an array of numbers, not {type(values).__name__}"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{reason}; of a Mitsuba scene, hand over the dict alone")
    image = to_float(texels) if texels.dtype in (np.uint8, np.uint16) else texels.astype(np.float32)
    image = image[..., None] if image.ndim == 2 else image
    if image.ndim != 3 or image.shape[2] not in (1, 3, 4) or image.size == 0:
        reason = f"an image is (H, W), (H, W, 1), (H, W, 3) or (H, W, 4), not {texels.shape}"
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{reason}; pass several as a list")
    finite = np.isfinite(image).all(axis=2)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        wrong = f"{np.count_nonzero(~finite)} pixels are NaN or infinite, the first at row {row}, column {column}"
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{wrong}; repair the render")
    return np.repeat(image, 3, axis=2) if image.shape[2] == 1 else image


def _size(image: NDArray[np.float32]) -> str:
    height, width, channels = image.shape
    return f"{width} x {height} x {channels}"
