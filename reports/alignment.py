"""The contact sheet of ``facezip check``: every expression's texture, and where it lies off the neutral's."""

from collections.abc import Sequence
from functools import partial
from io import BytesIO
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from facezip.character.alignment import SURE, THRESHOLD, Alignment, Alignments, severity, worst_tile
from facezip.character.displacement import GRID
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.files.writing import write_whole

COLOUR_MAP, INK, PAPER, ALARM = "inferno", "#e8e6e3", "#18191b", "#ff8a5c"
# Of one picture on the sheet, in inches and in texels.
PANEL, TEXELS = 2.2, 256
# One arrow for so many cells each way.
ARROWS = 2


def write_contact_sheet(path: Path, character: Character, found: Alignments) -> None:
    """Write a PNG: a heat map of the displacement's length over every texture, arrows, and one scale for all.

    The worst expression comes first, and of each the worst tile; what is wrong besides the displacement stands in
    words. Where nothing is known there is neither colour nor arrow.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    content = BytesIO()
    contact_sheet(character, found).savefig(content, format="png", facecolor=PAPER, metadata={"Software": None})
    write_whole(path, content.getvalue())


def contact_sheet(character: Character, found: Alignments) -> Figure:
    """The figure of :func:`write_contact_sheet`."""
    worst = {name: (tile := worst_tile(tiles), tiles[tile]) for name, tiles in found.items()}
    worst = dict(sorted(worst.items(), key=lambda pair: _severity(pair[1][1]), reverse=True))
    columns = min(len(worst), 7 if len(worst) > 8 else 4)
    rows = -(-len(worst) // columns)
    limit = _limit([alignment for _, alignment in worst.values()])
    figure = Figure(figsize=(columns * PANEL + 0.3, rows * (PANEL + 0.28) + 1.0), facecolor=PAPER, dpi=110)
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, (name, (tile, alignment)) in zip(axes.flat, worst.items(), strict=False):
        _panel(axis, character, name, tile, alignment, limit * alignment.unit)
    # Tiles may have different sizes; the scale is of the first.
    first = min(character.tiles)
    unit = next(iter(found.values()))[first].unit
    of_first = f" of tile {first}" if len({one.unit for tiles in found.values() for one in tiles.values()}) > 1 else ""
    heat = ScalarMappable(Normalize(0, limit * unit), COLOUR_MAP)
    height = figure.get_figheight()
    figure.subplots_adjust(0.01, 0.8 / height, 0.99, 1 - 0.3 / height, 0.03, 0.13)
    bar = figure.colorbar(heat, cax=figure.add_axes((0.2, 0.5 / height, 0.6, 0.1 / height)), orientation="horizontal")
    label = f"displacement in texels{of_first}; an expression off by more than {THRESHOLD * unit:g} (rms) is named"
    bar.set_label(label, color=INK)
    bar.ax.tick_params(colors=INK)
    bar.outline.set_edgecolor(INK)
    return figure


def _severity(alignment: Alignment) -> tuple[int, float]:
    return severity(alignment.state, alignment.rms / alignment.unit)


def _panel(axis: Axes, character: Character, name: str, tile: int, alignment: Alignment, limit: float) -> None:
    show = partial(axis.imshow, extent=(0, GRID, GRID, 0), interpolation="bilinear", vmin=0)
    show(_backdrop(character, name, tile), cmap="gray", vmax=1)
    # What is registered does not hide the skin.
    opacity = 0.85 * alignment.confidence * np.clip(alignment.length / (THRESHOLD * alignment.unit), 0, 1)
    show(alignment.length, cmap=COLOUR_MAP, vmax=limit, alpha=opacity)
    some = slice(ARROWS // 2, None, ARROWS)
    rows, columns = np.mgrid[some.start : GRID : ARROWS, some.start : GRID : ARROWS]
    sure = alignment.confidence[some, some] > SURE
    across, down = np.moveaxis(alignment.displacement[some, some], 2, 0)
    axis.quiver(
        columns[sure] + 0.5, rows[sure] + 0.5, across[sure], down[sure],
        angles="xy", scale_units="xy", scale=limit / (1.5 * ARROWS), width=0.006, color=INK,
    )  # fmt: skip
    colour = INK if alignment.state == "registered" else ALARM
    where = f" on {tile}" if len(character.tiles) > 1 else ""
    number = "?" if alignment.state == "unknown" else f"{alignment.rms:.2f}"
    axis.set_title(f"{name}{where}  {number}", color=colour, fontsize=9, pad=3)
    axis.text(
        0.5, 0.02, fill(alignment.why, 32), transform=axis.transAxes, ha="center", va="bottom", color=ALARM, fontsize=8
    )


def _backdrop(character: Character, name: str, tile: int) -> NDArray[np.float32]:
    step = max(max(character.stacks[ALBEDO, tile].resolution) // TEXELS, 1)
    grey: NDArray[np.float32] = 0.8 * character.texture(name, tile=tile)[::step, ::step].mean(axis=2)
    return grey


def _limit(found: Sequence[Alignment]) -> float:
    """The end of the scale, in units: a power of two that the worst just fits, twice the threshold at least."""
    worst = max([2 * THRESHOLD, *(alignment.worst[0] / alignment.unit for alignment in found)])
    return float(2 ** np.ceil(np.log2(worst)))
