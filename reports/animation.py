"""The report of ``facezip animate``: the loop, the error over its frames, a contact sheet, and every number."""

import base64
from collections.abc import Sequence
from pathlib import Path

from facezip.character.maps import ALBEDO
from facezip.documents.document import plain, to_json
from facezip.files.writing import write_whole
from render.documents.animation import AnimationDocument, Frame, FrameMeans
from render.paired import Images
from reports.conditions import condition_rows
from reports.findings import Finding
from reports.frames import Reel, moving, sheet
from reports.maps import headlines, unit_of
from reports.metrics import METRICS, number
from reports.page import write_page
from reports.plots import Axis, Label, Plot, dot, line
from reports.sections import Section, Strip
from reports.tables import Cell, Row, Table

PAGE, DATA, LOOP = "index.html", "animation.json", "animation.webp"
SHOWN = ("texture_rmse", "image_rmse", "flip", "delta_e_p95", "ssim")
# Columns of the contact sheet.
COLUMNS = 8

Numbers = Frame | FrameMeans


def is_animation(folder: Path) -> bool:
    """Whether a folder is such a report."""
    return (folder / DATA).is_file()


def write_animation_report(document: AnimationDocument, images: Sequence[Images], folder: Path) -> Path:
    """Write ``index.html``, ``animation.json`` and ``animation.webp``.

    Parameters
    ----------
    document : of :func:`render.animation.animate`, with ``pack`` and ``command``.
    images : of every frame, original and compressed.
    folder : where the files go, each whole or not at all.

    Returns
    -------
    The path of the page.
    """
    data = plain(document)
    reel = Reel.of(images)
    loop = moving(reel)
    write_whole(folder / LOOP, loop)
    write_whole(folder / DATA, to_json(document).encode())
    return write_page(
        folder / PAGE,
        "animation.html",
        document={**data, "findings": plain(_findings(document))},
        data_name=DATA,
        loop_name=LOOP,
        loop="data:image/webp;base64," + base64.b64encode(loop).decode("ascii"),
        still=reel.uri(document.worst),
        size=reel.size,
        worst=document.frames[document.worst],
        scale=reel.scale,
        kicker=f"Animated blend, original against {document.pack}",
        title=f"{document.character.name} in motion – FaceZip",
        sections=[_errors(document), _contact_sheet(document, reel)],
        conditions=condition_rows(data),
        stances={},
    )


def _findings(document: AnimationDocument) -> list[Finding]:
    worst, means, last = document.frames[document.worst], document.means, len(document.frames) - 1
    return [
        Finding(
            title=f"Worst frame: {worst.frame} of 0..{last}, {worst.pose}",
            here=f"{_numbers(worst)}. β: {_blend(worst)}.",
        ),
        Finding(title=f"All {last + 1} frames in the mean", here=f"{_numbers(means)}."),
        Finding(
            title="The original",
            here=f"{document.original[:1].upper()}{document.original[1:]}. Both sides have the same geometry.",
        ),
    ]


def _numbers(values: Numbers) -> str:
    shown = [metric for metric in METRICS if metric.key in SHOWN]
    images = ", ".join(f"{metric.label} {metric.text(getattr(values, metric.key))}" for metric in shown)
    return "; ".join(filter(None, [images, headlines(values.map_errors)]))


def _blend(frame: Frame) -> str:
    return ", ".join(f"{name} {number(value, 2)}" for name, value in frame.weights.items()) or "neutral"


def _errors(document: AnimationDocument) -> Section:
    intro = "RMSE of a frame’s head pixels, 0 to 255."
    plots = ((_plot(document, 1200.0), _plot(document, 380.0)),)
    return Section(
        "frames", "Frames", "Error over the frames", intro, plots=plots, tables=(_table(document),), folded=True
    )


def _plot(document: AnimationDocument, width: float) -> Plot:
    frames = document.frames
    left, right, top, bottom = 52.0, width - 12, 36.0, 300.0
    wide = width > 600
    step = max(4 * round(len(frames) / (24 if wide else 8) / 4), 1)
    last = max(len(frames) - 1, 1)
    across = Axis(0, last, left + 6, right, tuple(range(0, last + 1, step)))
    up = Axis.around([frame.image_rmse for frame in frames], bottom, top, zero=True)
    spots = [(across.at(frame.frame), up.at(frame.image_rmse)) for frame in frames]
    marks = [line(spots, "pack-0", width=2)]
    marks += [
        dot(at, "disc", "pack-0", f"frame {frame.frame}, {frame.pose}: {number(frame.image_rmse, 2)}", 3)
        for at, frame in zip(spots, frames, strict=True)
    ]
    worst = frames[document.worst]
    x, y = spots[document.worst]
    marks.append(dot((x, y), "diamond", "bad", f"worst: {worst.pose}", 6))
    anchor = "end" if x > (left + right) / 2 else "start"
    words = f"worst: frame {worst.frame}, {worst.pose}, {number(worst.image_rmse, 2)}"
    labels = [Label(x, round(y - 12, 1), words, anchor)]
    frame = (width, bottom + 48, left, right, top, bottom)
    return Plot("", *frame, across.marks(), up.marks(), "Frame", "Image RMSE, of 255", tuple(marks), tuple(labels))


def _table(document: AnimationDocument) -> Table:
    shown = [metric for metric in METRICS if metric.key in SHOWN]
    maps = {name: found for name, found in document.means.map_errors.items() if name != ALBEDO}

    def cells(values: Numbers) -> tuple[Cell, ...]:
        errors = (number(values.map_errors[name].mean, 2) for name in maps)
        return tuple(map(Cell, [*(metric.text(getattr(values, metric.key)) for metric in shown), *errors]))

    rows = [Row(f"{frame.frame}", cells(frame), frame.pose) for frame in document.frames]
    rows.append(Row("mean", cells(document.means), strong=True))
    others = (f"{name.capitalize()}, {unit_of(found)}" for name, found in maps.items())
    return Table("Every frame.", "Frame", (*(metric.label for metric in shown), *others), tuple(rows))


def _contact_sheet(document: AnimationDocument, reel: Reel) -> Section:
    chosen = _chosen(len(document.frames), document.worst)
    names = [f"{n} {document.frames[n].pose}" + (" (worst)" if n == document.worst else "") for n in chosen]
    strip = Strip("; ".join(names), sheet(reel, chosen), "frames from left to right")
    intro = (
        "Original above, compressed in the middle, their difference below: the largest of the three channels, black "
        f"for none, lightest at {reel.scale.limit:g} of 255 and above ({reel.scale.factor:g} times amplified)."
    )
    return Section("contact-sheet", "Contact sheet", "Contact sheet", intro, strips=(strip,))


def _chosen(count: int, worst: int) -> list[int]:
    """The frames of the contact sheet, of so many, in their order; all where there are few."""
    columns = min(COLUMNS, count)
    # The lowest and the highest of every stretch would tell less: even steps, and the worst in the place of its next.
    chosen = [round(i * count / columns) for i in range(columns)]
    nearest = min(range(columns), key=lambda i: abs(chosen[i] - worst))
    chosen[nearest] = worst
    return chosen
