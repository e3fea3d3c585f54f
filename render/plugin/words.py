"""What a comparison says, in numbers and in a few lines."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from render.plugin.reference import Comparison, Reference


def worst_place(comparison: "Comparison", reference: "Reference") -> dict[str, Any]:
    """The block, of the size that tells most, whose ratio is largest.

    Returns
    -------
    ``row``, ``column`` of its upper left pixel, its ``side``, the means of ``image`` and ``reference`` over it in the
    channel that tells most, and their difference in ``deviations``, standard errors.
    """
    import numpy as np

    values = comparison.ratios[comparison.scale].values
    row, column, channel = map(int, np.unravel_index(np.abs(values).argmax(), values.shape))
    side, step = comparison.scale, max(comparison.scale // 2, 1)
    block = (slice(row * step, row * step + side), slice(column * step, column * step + side), channel)
    return {
        "row": row * step,
        "column": column * step,
        "side": side,
        "image": float(comparison.image[block].mean()),
        "reference_image": float(reference.mean[block].mean()),
        "deviations": float(values[row, column, channel]),
    }


def described(result: dict[str, Any]) -> str:
    """A failed comparison in a few lines."""
    many = f"\n  nor does it agree with the {result['accepted'] - 1} others" if result.get("accepted", 1) > 1 else ""
    return (
        f"differs from its reference by more than noise: p = {result['probability']:.1e}, level {result['level']:g}\n"
        f"  worst {place(result)}: {result['image']:.4g} instead of {result['reference_image']:.4g}, "
        f"{abs(result['deviations']):.1f} standard errors\n"
        f"  reference {result['reference']}{many}\n"
        f"  evidence {result['evidence']}: image, reference, error, p_value as EXR and PNG"
    )


def described_agreement(result: dict[str, Any]) -> str:
    """An image that had to differ and does not."""
    likely = f"p = {result['probability']:.1e}, level {result['level']:g}"
    return (
        f"agrees with its reference, though it must differ: {likely}\n"
        f"  reference {result['reference']}\n"
        f"  evidence {result['evidence']}: image, reference, error, p_value as EXR and PNG"
    )


def place(result: dict[str, Any]) -> str:
    """Where a comparison differs most."""
    side = result["side"]
    return (
        f"{f'{side} x {side} pixels from' if side > 1 else 'pixel at'} row {result['row']}, column {result['column']}"
    )


def size(shape: tuple[int, ...]) -> str:
    """Width, height and channels of an ``(H, W, C)`` image."""
    return " x ".join(str(side) for side in (shape[1], shape[0], *shape[2:]))
