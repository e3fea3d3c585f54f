"""What a failed comparison leaves behind: four pictures, for programs and for people."""

import shutil
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray

from facezip.files.images import write_texture
from facezip.files.writing import whole_folder
from render.exr import write_exr
from render.metrics import display
from render.plugin.reference import Comparison, Reference
from render.plugin.statistics import ratio_probabilities

PICTURES = ("image", "reference", "error", "p_value")
# Small images are shown with their pixels enlarged to at least this side.
_SHOWN_SIDE = 256
# A probability of 1e-10 or less has the lightest colour.
_DECADES = 10.0


def write_evidence(folder: Path, comparison: Comparison, reference: Reference) -> None:
    """Write ``image``, ``reference``, ``error`` and ``p_value``, each as EXR and as PNG, into a folder, whole or not.

    The error is image minus reference. The EXR of the probabilities has a part for every size of blocks, the PNG shows
    the smallest of them; each is corrected for the number of blocks of its size.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``; also where the folder holds something else.
    """
    probabilities = probability_maps(comparison)
    error = comparison.image - reference.mean
    linear = {"image": comparison.image, "reference": reference.mean}
    shown = {name: _opaque(display(image)) for name, image in linear.items()}
    shown["error"] = signed_colours(error[..., :3].mean(axis=2))
    shown["p_value"] = probability_colours(np.min([*probabilities.values()], axis=0))
    with whole_folder(folder, True, is_evidence) as place:
        for name, image in {**linear, "error": error}.items():
            write_exr(place / f"{name}.exr", {name: image}, {})
        write_exr(place / "p_value.exr", {f"{scale} px": _grey(one) for scale, one in probabilities.items()}, {})
        for name, picture in shown.items():
            write_texture(place / f"{name}.png", enlarged(picture))


def remove_evidence(folder: Path) -> None:
    """Remove what :func:`write_evidence` wrote, if it is there, and nothing else."""
    if is_evidence(folder):
        shutil.rmtree(folder)


def is_evidence(folder: Path) -> bool:
    """Whether a folder is one of :func:`write_evidence`."""
    return folder.is_dir() and {path.name for path in folder.iterdir()} == {
        f"{name}.{kind}" for name in PICTURES for kind in ("exr", "png")
    }


def probability_maps(comparison: Comparison) -> dict[int, NDArray[np.float32]]:
    """``(H, W)`` for every size of blocks: the smallest probability of the channels and blocks that cover a pixel."""
    height, width, _ = comparison.image.shape
    maps = {}
    for scale, ratios in comparison.ratios.items():
        cells = ratio_probabilities(ratios).min(axis=2)
        step = max(scale // 2, 1)
        for axis, size in enumerate((height, width)):
            cells = _covering(cells, axis, -(-size // step)).repeat(step, axis)
        maps[scale] = cells[:height, :width].astype(np.float32)
    return maps


def _covering(cells: NDArray[np.float64], axis: int, steps: int) -> NDArray[np.float64]:
    """From overlapping blocks to the half blocks that they share: the smaller of the two."""
    if cells.shape[axis] == steps:
        return cells
    first, last = cells.take([0], axis), cells.take([-1], axis)
    return np.minimum(np.concatenate([first, cells], axis), np.concatenate([cells, last], axis))


def signed_colours(error: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(H, W, 3)`` colours in [0, 1] of an ``(H, W)`` error: orange where too bright, violet where too dark."""
    reach = float(np.percentile(np.abs(error), 99.5)) or 1.0
    return _coloured("PuOr_r", 0.5 + error / (2 * reach))


def probability_colours(probabilities: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(H, W, 3)`` colours in [0, 1] of ``(H, W)`` probabilities: black for 1, light for what noise never does."""
    return _coloured("inferno", -np.log10(np.maximum(probabilities, 1e-30)) / _DECADES)


def _coloured(name: str, values: NDArray[np.floating]) -> NDArray[np.float32]:
    return np.asarray(matplotlib.colormaps[name](np.clip(values, 0, 1)), np.float32)[..., :3]


def enlarged(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """The picture with every pixel as a square, large enough to be seen."""
    factor = max(1, -(-_SHOWN_SIDE // max(picture.shape[:2])))
    return picture.repeat(factor, 0).repeat(factor, 1)


def _opaque(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    return picture[..., :3]


def _grey(image: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.repeat(image[..., None], 3, axis=2)
