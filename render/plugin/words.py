"""What a comparison says, in numbers and in a few lines."""

from typing import TYPE_CHECKING

from render.plugin.results import Compared, Place, Result

if TYPE_CHECKING:
    from render.plugin.reference import Comparison, Reference


def worst_place(comparison: "Comparison", reference: "Reference") -> Place:
    """The block, of the size that tells most, whose ratio is largest."""
    import numpy as np

    values = comparison.ratios[comparison.scale].values
    row, column, channel = map(int, np.unravel_index(np.abs(values).argmax(), values.shape))
    side, step = comparison.scale, max(comparison.scale // 2, 1)
    block = (slice(row * step, row * step + side), slice(column * step, column * step + side), channel)
    return Place(
        row=row * step,
        column=column * step,
        side=side,
        image=float(comparison.image[block].mean()),
        reference=float(reference.mean[block].mean()),
        deviations=float(values[row, column, channel]),
    )


def described(result: Result, compared: Compared) -> str:
    """A failed comparison in a few lines."""
    worst = compared.place
    many = f"\n  nor does it agree with the {compared.accepted - 1} others" if compared.accepted > 1 else ""
    return (
        f"differs from its reference by more than noise: {_likely(result, compared)}\n"
        f"  worst {where(worst)}: {worst.image:.4g} instead of {worst.reference:.4g}, "
        f"{abs(worst.deviations):.1f} standard errors\n"
        f"  reference {result.reference}{many}\n"
        f"  evidence {result.evidence}: image, reference, error, p_value as EXR and PNG"
    )


def described_agreement(result: Result, compared: Compared) -> str:
    """An image that had to differ and does not."""
    return (
        f"agrees with its reference, though it must differ: {_likely(result, compared)}\n"
        f"  reference {result.reference}\n"
        f"  evidence {result.evidence}: image, reference, error, p_value as EXR and PNG"
    )


def where(place: Place) -> str:
    """A block of pixels, or a single one."""
    block = f"{place.side} x {place.side} pixels from" if place.side > 1 else "pixel at"
    return f"{block} row {place.row}, column {place.column}"


def _likely(result: Result, compared: Compared) -> str:
    return f"p = {compared.probability:.1e}, level {result.level:g}"


def size(shape: tuple[int, ...]) -> str:
    """Width, height and channels of an ``(H, W, C)`` image."""
    return " x ".join(str(side) for side in (shape[1], shape[0], *shape[2:]))
