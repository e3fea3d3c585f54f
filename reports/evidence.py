"""The contact sheet of ``facezip rig``: where scans show a shape's texture, and where it stays the neutral's."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from facezip.files.writing import write_whole
from facezip.rigging.evidence import Estimate
from facezip.rigging.rigged import Rigged
from facezip.rigging.shown import shown
from reports.alignment import INK, PAPER

COLOUR_MAP = "viridis"
PANEL, COLUMNS = 1.35, 9
# Where a shape is expected to change less than this part of its largest change, nothing is drawn.
FAINT = 0.05


def write_evidence(path: Path, made: Rigged) -> None:
    """Write a PNG: for every shape, on the tile where it changes most, how much of its change scans determine.

    Colour is the evidence from 0 to 1, and strong where the shape is expected to change the skin; a shape's number is
    that of ``shown`` in the record.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    names = made.model.expressions
    facts = shown(made.estimates, names)
    columns = min(len(names), COLUMNS)
    rows = -(-len(names) // columns)
    figure = Figure(figsize=(columns * PANEL + 0.2, rows * (PANEL + 0.28) + 0.9), facecolor=PAPER, dpi=110)
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for m, (axis, name) in enumerate(zip(axes.flat, names, strict=False)):
        heat = _panel(axis, made, m)
        axis.set_title(f"{name} {facts[name].shown:.2f}", color=INK, fontsize=6, pad=2)
    height = figure.get_figheight()
    figure.subplots_adjust(0.01, 0.7 / height, 0.99, 1 - 0.25 / height, 0.03, 0.2)
    bar = figure.colorbar(heat, cax=figure.add_axes((0.2, 0.45 / height, 0.6, 0.08 / height)), orientation="horizontal")
    bar.set_label("part of a shape's change that scans determine; 0: it stays the neutral's", color=INK, fontsize=8)
    bar.ax.tick_params(colors=INK, labelsize=7)
    bar.outline.set_edgecolor(INK)
    content = BytesIO()
    figure.savefig(content, format="png", facecolor=PAPER, metadata={"Software": None})
    write_whole(path, content.getvalue())


def _panel(axis: Axes, made: Rigged, m: int) -> Any:
    estimate = max(made.estimates.values(), key=lambda one: float(one.expected[m].max()))
    axis.imshow(np.zeros((1, 1)), cmap="gray", vmin=0, vmax=4, extent=(0, 1, 0, 1))
    return axis.imshow(
        estimate.evidence[m], cmap=COLOUR_MAP, vmin=0, vmax=1, alpha=_opacity(estimate, m), extent=(0, 1, 0, 1)
    )


def _opacity(estimate: Estimate, m: int) -> NDArray[np.float32]:
    expected = estimate.expected[m]
    share = expected / max(float(expected.max()), np.finfo(np.float32).tiny)
    found: NDArray[np.float32] = np.where(share < FAINT, 0, np.clip(4 * share, 0, 1)).astype(np.float32)
    return found
