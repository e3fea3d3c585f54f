"""A sentence that a person acts on, from the errors of a pack."""

from typing import Any

# A ΔE2000 of one is what an observer just notices side by side; a mean FLIP of 0.05 is plain to see when flipping.
INVISIBLE_DELTA_E = 1.0
VISIBLE_DELTA_E = 3.0
VISIBLE_FLIP = 0.05


def verdict(pack: dict[str, Any]) -> tuple[str, str]:
    """Judge a pack by its worst render: indistinguishable, visible, or failing; with where and by how much.

    Parameters
    ----------
    pack : the metrics of a pack with ``worst`` for each of them, as in the validation document.

    Returns
    -------
    level : ``"identical"``, ``"indistinguishable"``, ``"visible"`` or ``"fails"``.
    sentence : the same for a person, with figures.
    """
    colour, flip = pack["worst"]["delta_e_p95"], pack["worst"]["flip"]
    where = f"{colour['expression']}, {colour['view'].replace('_', ' ')} view, {colour['light']} light"
    figures = f"95 % of head pixels within dE2000 {colour['value']:.1f} at worst ({where})"
    if pack["image_rmse"] == 0:
        return "identical", "Identical: every rendered pixel is the same."
    if colour["value"] <= INVISIBLE_DELTA_E and flip["value"] <= VISIBLE_FLIP:
        return "indistinguishable", f"Indistinguishable: {figures}."
    if colour["value"] <= VISIBLE_DELTA_E and flip["value"] <= 2 * VISIBLE_FLIP:
        return "visible", f"Visible side by side: {figures}."
    return "fails", f"Fails: {figures}; mean FLIP up to {flip['value']:.3f}."
