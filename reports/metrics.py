"""What reports call each metric, how they print it, and what it means."""

from collections.abc import Iterable
from dataclasses import dataclass

from facezip.documents.document import Data


@dataclass(frozen=True)
class Metric:
    """One column of numbers.

    Attributes
    ----------
    key : its name in ``report.json``.
    label, unit : as a table prints them.
    digits : decimals of its numbers.
    higher_is_better : the direction of quality.
    meaning : one or two sentences for a reader who meets it for the first time.
    """

    key: str
    label: str
    unit: str
    digits: int
    higher_is_better: bool
    meaning: str

    def text(self, value: float | None) -> str:
        """The value as text; only an infinite PSNR has none, and is printed as infinite."""
        if value is None:
            return "∞" if self.key == "psnr" else MISSING
        return number(value, self.digits)

    def of(self, values: Data) -> str:
        """The metric's value out of a document's numbers, as text; a dash where it was not measured."""
        return self.text(values[self.key]) if self.key in values else MISSING


MISSING = "–"

METRICS = (
    Metric(
        "texture_rmse", "Texture RMSE", "of 255", 2, False,
        "Root mean square error of the decompressed texture against the scanned one, over the texels of the texture "
        "region and all channels, in encoded values 0 to 255. The paper's measure; it knows nothing of light or view.",
    ),
    Metric(
        "image_rmse", "Image RMSE", "of 255", 2, False,
        "Root mean square error between the two renders over head pixels, in encoded (sRGB) values 0 to 255. Both are "
        "shaded on the same light paths, so that nearly all of it is compression and nearly none of it noise.",
    ),
    Metric(
        "image_rmse_debiased", "Debiased RMSE", "of 255", 2, False,
        "Image RMSE from two independent halves of the samples: neither noise nor the display's curve biases it.",
    ),
    Metric(
        "psnr", "PSNR", "dB", 1, True,
        "Image RMSE against the full range on a logarithmic scale: 20 log₁₀(255 / RMSE). Infinite for equal images.",
    ),
    Metric(
        "delta_e_mean", "ΔE2000 mean", "", 2, False,
        "CIEDE2000 colour difference averaged over head pixels. About 1 is the smallest difference that a trained eye "
        "sees between two large patches side by side.",
    ),
    Metric(
        "delta_e_p95", "ΔE2000 p95", "", 2, False,
        "CIEDE2000 that 95 % of the head pixels stay below: it follows the places where the eye would find something.",
    ),
    Metric(
        "delta_e_local", "ΔE2000 in the worst place", "", 2, False,
        "The largest mean of CIEDE2000 over a window of a quarter of a degree (17 x 17 pixels): a spoilt mouth is less "
        "than 5 % of a head, and no percentile of the whole sees it.",
    ),
    Metric(
        "flip", "FLIP", "0…1", 4, False,
        "Difference that a person perceives when alternating between both images at the stated pixels per degree: "
        "0 none, 1 the largest. It models contrast sensitivity, colour, edges and points (Andersson et al. 2020).",
    ),
    Metric(
        "ssim", "SSIM", "0…1", 4, True,
        "Structural similarity of luminance, contrast and structure in small windows: 1 for equal images "
        "(Wang et al. 2004).",
    ),
)  # fmt: skip

IMAGE_METRICS = METRICS[1:]
FLOOR = (
    "Noise floor",
    "The metric between two independent renders of the original: what the renderer's random numbers alone would show.",
)
BY_KEY = {metric.key: metric for metric in METRICS}


def number(value: float, digits: int) -> str:
    """A number with fixed decimals that never passes a small value off as none: exact ones and zeros stay bare."""
    if value in (0, 1):
        return str(int(value))
    if abs(value) < 0.5 * 10**-digits:
        return f"{'>-' if value < 0 else '<'}{10**-digits:.{digits}f}"
    return f"{value:.{digits}f}"


def megabytes(count: float) -> str:
    """Bytes in MB, powers of ten as in the paper: ``4.26``."""
    return number(count / 1e6, 2)


def floor_text(metric: Metric, entry: Data) -> str:
    """The noise floor of a metric of a pack or a render as text; nothing where it was not measured."""
    floors = entry.get("noise_floor_per_metric", entry["noise_floor"])
    return metric.of(floors) if metric.key in floors else ""


def measured(metrics: Iterable[Metric], entries: Iterable[Data]) -> tuple[Metric, ...]:
    """The metrics that at least one of the entries has."""
    keys = {key for entry in entries for key in entry}
    return tuple(metric for metric in metrics if metric.key in keys)
