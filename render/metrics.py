"""How different two images of a head look: RMSE, PSNR, SSIM, FLIP and ΔE2000 over the pixels of the head.

Images are display-referred: encoded sRGB in [0, 1]. Every metric is exactly zero (SSIM exactly one) for equal images.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from facezip.files.srgb import encode_srgb
from render.colour import Colours, delta_e_2000, to_lab
from render.documents.images import ImageMetrics
from render.flip import Seen, flip, seen

MARGIN = 12

# The window that a small error has to fill: a quarter of a degree, in pixels of FLIP's display.
WINDOW = 17

METRICS = ("image_rmse", "flip", "delta_e_mean", "delta_e_p95", "delta_e_local", "ssim")
UNITS = {
    "texture_rmse": "0..255, encoded sRGB, over texels and channels of the face region",
    "image_rmse": "0..255, encoded sRGB, over head pixels and channels",
    "image_rmse_debiased": "0..255; from two independent halves of the samples, free of render noise",
    "noise_floor": "0..255; RMSE of the original against itself with other random numbers",
    "psnr": "dB, peak 255; null for equal images",
    "flip": "mean FLIP over head pixels, 0..1",
    "delta_e_mean": "mean CIEDE2000 over head pixels",
    "delta_e_p95": "95th percentile of CIEDE2000 over head pixels",
    "delta_e_local": f"largest mean of CIEDE2000 over the head pixels of a window of {WINDOW} x {WINDOW} pixels",
    "ssim": "mean SSIM of the encoded luma over head pixels, 1 for equal images",
}


@dataclass(frozen=True, eq=False)
class Picture:
    """A display-referred image, cropped around the head; what metrics make of it alone is made once.

    Attributes
    ----------
    encoded : ``(h, w, 3)`` float32 in [0, 1], sRGB.
    head : ``(h, w)`` bool, pixels that the head fills at least half.
    """

    encoded: NDArray[np.float32]
    head: NDArray[np.bool_]

    @cached_property
    def lab(self) -> Colours:
        """``(n, 3)`` CIELAB of the head pixels."""
        return to_lab(self.encoded[self.head])

    @cached_property
    def seen(self) -> Seen:
        """The crop as FLIP sees it."""
        return seen(self.encoded)


def display(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Scene-linear radiance as a display shows it: clipped to [0, 1] and sRGB-encoded."""
    return encode_srgb(np.clip(linear, 0, 1))


def head_crop(coverage: NDArray[np.float32]) -> tuple[slice, slice]:
    """Rows and columns around the head pixels of a ``(H, W)`` coverage, with a margin; everything without a head."""
    rows, columns = (np.flatnonzero((coverage >= 0.5).any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return slice(0, coverage.shape[0]), slice(0, coverage.shape[1])
    return _span(rows, coverage.shape[0]), _span(columns, coverage.shape[1])


def _span(indices: NDArray[np.intp], size: int) -> slice:
    return slice(max(int(indices[0]) - MARGIN, 0), min(int(indices[-1]) + 1 + MARGIN, size))


def compare(original: Picture, other: Picture) -> ImageMetrics:
    """Every metric of ``other`` against ``original``, two pictures of the same crop."""
    head = original.head
    rmse = image_rmse(original.encoded[head], other.encoded[head])
    return ImageMetrics(
        image_rmse=rmse,
        psnr=None if rmse == 0 else float(20 * np.log10(255 / rmse)),
        ssim=float(ssim_map(original.encoded, other.encoded)[head].mean()),
        **perceived(original, other),
    )


def image_rmse(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Root mean square error of encoded values, in units of 0..255."""
    return float(255 * np.sqrt(np.mean(np.square(a.astype(np.float64) - b))))


def perceived(original: Picture, other: Picture) -> dict[str, float]:
    """FLIP and CIEDE2000 over head pixels, by the names of metrics.

    The largest mean of a window is beside the others, since a percentile of the whole head does not see a small place.
    """
    colour = delta_e_2000(original.lab, other.lab)
    return {
        "flip": float(flip(original.seen, other.seen)[original.head].mean(dtype=np.float64)),
        "delta_e_mean": float(colour.mean()),
        "delta_e_p95": float(np.percentile(colour, 95)),
        "delta_e_local": float(window_means(colour, original.head).max(initial=0)),
    }


def window_means(values: NDArray[np.floating[Any]], head: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Means of head pixels' values ``(n,)``, in the order of ``head`` ``(h, w)``, over the windows around them.

    A window that the head fills less than half counts as half filled: a few pixels at the outline are no place.
    """
    placed = np.zeros(head.shape)
    placed[head] = values
    total, filled = (uniform_filter(image, WINDOW, mode="constant") for image in (placed, head.astype(np.float64)))
    means: NDArray[np.float64] = np.maximum(total, 0)[head] / np.maximum(filled[head], 0.5)
    return means


def ssim_map(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float64]:
    """Structural similarity ``(h, w)`` of encoded luma (Wang et al. 2004: Gaussian window, σ = 1.5)."""
    from skimage.metrics import structural_similarity

    luma = np.array([0.299, 0.587, 0.114])
    _, similarity = structural_similarity(
        a @ luma,
        b @ luma,
        data_range=1.0,
        full=True,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
    )
    return np.asarray(similarity, np.float64)
