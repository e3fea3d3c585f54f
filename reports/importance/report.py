"""The report of ``facezip importance``: findings, heat maps, and the effect look by look."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.scans import Character
from facezip.documents.document import plain, to_json
from facezip.files.writing import write_whole
from render.importance import Sight
from reports.conditions import condition_rows
from reports.figures import Series, lying_bars, upright_bars
from reports.findings import Finding
from reports.importance.documents import FitFacts, ImportanceDocument, LookErrors, Pair
from reports.importance.pictures import head_panels, scale_of, uv_panels
from reports.maps import unit_of
from reports.metrics import megabytes, number
from reports.page import write_page
from reports.tables import Cell, Row, Table

PAGE, DATA = "index.html", "importance.json"
TONES = {"uniform": "rival-2", "importance": "pack-0"}


def write_importance_report(
    document: ImportanceDocument,
    character: Character,
    importance: Mapping[Key, NDArray[np.float32]],
    sight: Sight,
    folder: Path,
) -> Path:
    """Write ``importance.json`` and the page ``index.html`` that shows the same numbers; returns the page's path.

    Parameters
    ----------
    document : what :func:`reports.importance.experiment.measure_importance` returned; optional ``command``.
    character, importance, sight : what the heat maps show, and from where.
    folder : where both files go, each whole or not at all.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    document = replace(document, findings=find(document))
    data = plain(document)
    write_whole(folder / DATA, to_json(document).encode())
    scale = scale_of(document.importance)
    return write_page(
        folder / PAGE,
        "importance.html",
        document=data,
        data_name=DATA,
        title=f"{character.name} – importance of texels, by FaceZip",
        scale=scale,
        heads=head_panels(character, importance, sight, scale),
        uv=uv_panels(character, importance, scale),
        series=(bars := error_series(document.looks)),
        wide=upright_bars(list(bars[0].values), bars),
        narrow=lying_bars(list(bars[0].values), bars),
        looks=looks_table(document.looks),
        fits=fits_table(document.fits),
        conditions=condition_rows(data),
    )


def find(document: ImportanceDocument) -> list[Finding]:
    """What the numbers say."""
    change, facts = document.change, document.importance
    found = [
        Finding(
            title="Seen",
            here=f"The cameras see {facts.seen_share:.0%} of the face region in one expression or more; "
            f"every other texel counts {facts.floor:g} of the mean.",
        ),
        *([Finding(title="Maps", here=_maps(document))] if len(document.character.maps) > 1 else []),
    ]
    for title, pair, worst in (
        ("The views it was made for", change.made_for, change.worst_made_for),
        ("Views that it knows nothing of", change.held_out, change.worst_held_out),
    ):
        if pair is not None and worst is not None:
            found.append(Finding(title=title, here=_sentence(pair, worst)))
    return found


def _maps(document: ImportanceDocument) -> str:
    """How much maps count beside each other."""
    counts = {name: count for name, count in document.importance.counts.items() if name != ALBEDO}
    shown = ", ".join(f"{name} {number(count, 3)}" for name, count in counts.items())
    return (
        f"Beside the albedo maps count as much as their differences show in the images, in parts of what they count "
        f"without an importance: {shown}."
    )


def _sentence(pair: Pair, worst: float) -> str:
    return (
        f"Image RMSE {number(pair.importance, 3)} of 255 with the importance, {number(pair.uniform, 3)} without, "
        f"at equal bytes: {_percent(pair.change)}; {_percent(worst)} in the worst look."
    )


def error_series(looks: Sequence[LookErrors]) -> list[Series]:
    """Image RMSE of every look, a bar for each fit."""
    names = [_name(look) for look in looks]
    fits = {"uniform": [look.uniform for look in looks], "importance": [look.importance for look in looks]}
    return [
        Series(fit, dict(zip(names, errors, strict=True)), number(float(np.mean(errors)), 3), TONES[fit])
        for fit, errors in fits.items()
    ]


def looks_table(looks: Sequence[LookErrors]) -> Table:
    """The same as numbers, with the change."""
    rows = [
        Row(
            _name(look),
            (
                Cell(number(look.uniform, 3)),
                Cell(number(look.importance, 3), best=look.change < 0),
                Cell(_percent(look.change)),
            ),
            note="held out" if look.held_out else "made for",
        )
        for look in looks
    ]
    caption = "Image RMSE of 255 over head pixels, root mean square over expressions; a negative change is a gain."
    return Table(caption, "Look", ("Uniform", "With importance", "Change"), tuple(rows))


def fits_table(fits: Sequence[FitFacts]) -> Table:
    """What both fits cost, and the error of each map: it rises where nobody looks."""
    maps = fits[0].map_errors
    rows = [
        Row(
            fit.name,
            (
                Cell(megabytes(fit.bytes_on_gpu)),
                Cell(str(fit.fetches)),
                *(Cell(number(fit.map_errors[name].mean, 3)) for name in maps),
            ),
        )
        for fit in fits
    ]
    errors = (f"{name.capitalize()}, {unit_of(found)}" for name, found in maps.items())
    columns = ("GPU memory, MB", "Fetches a pixel", *errors)
    return Table("The two fits: the same format and bytes.", "Fit", columns, tuple(rows))


def _name(look: LookErrors) -> str:
    view = look.view.replace("three_quarter", "¾").replace("_", " ")
    return f"{view} · {look.light}"


def _percent(share: float) -> str:
    return f"{100 * share:+.1f} %".replace("-", "−")
