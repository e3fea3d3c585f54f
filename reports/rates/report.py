"""The report of ``facezip rates``: findings, curves and tables, every number in its JSON."""

from dataclasses import replace
from pathlib import Path

from facezip.documents.document import Data, plain
from reports.experiments import write_experiments
from reports.rates import curves
from reports.rates.documents import RatesDocument
from reports.rates.findings import find
from reports.sections import Section

DATA = "rates.json"
# Two plots side by side, and one below the other on phones.
WIDE, NARROW = 570.0, 380.0


def write_rates_report(document: RatesDocument, folder: Path) -> Path:
    """Write ``rates.json`` and the page ``index.html`` that shows the same numbers; returns the page's path.

    Parameters
    ----------
    document : what :func:`reports.rates.experiment.measure_rates` returned; optional ``command``.
    folder : where both files go, each whole or not at all.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    return write_experiments(
        folder,
        DATA,
        replace(document, findings=find(plain(document))),
        lambda data: [section for one in data["rounds"] for section in (_section(one), _numbers(one))],
        kicker="Error against GPU memory and files: packs, and block compression of every texture",
        title=f"{document.character.name} – error against GPU memory, by FaceZip",
    )


def _section(one: Data) -> Section:
    count, maps = one["expressions"], list(curves.maps_of(one))
    together = f" Error and bytes are those of {', '.join(maps[:-1])} and {maps[-1]} together." if len(maps) > 1 else ""
    return Section(
        f"expressions-{count}",
        f"{count} expressions",
        f"{count} expressions",
        "Marks: everything that was tried. Lines: the best of each family. Lower and further left is better. Files are "
        "what a page loads: blocks in KTX2 under Zstandard, raw texels in PNG." + together,
        legend=curves.legend(one),
        plots=tuple((curves.curves(one, WIDE, size), curves.curves(one, NARROW, size)) for size in curves.SIZES),
        tables=(curves.comparison(one),),
    )


def _numbers(one: Data) -> Section:
    count = one["expressions"]
    intro = "Everything that was tried. Bold: nothing of its family has less error at no more bytes."
    title = f"{count} expressions, every measurement"
    return Section(f"measured-{count}", "as numbers", title, intro, tables=(curves.table(one),), folded=True)
