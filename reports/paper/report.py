"""The report of ``facezip paper``: findings first, then the paper's table and figures, every number in its JSON."""

from pathlib import Path

from reports.experiments import write_experiments
from reports.paper.documents.paper import PaperDocument
from reports.paper.findings import AGREES, BEYOND, DIFFERS
from reports.paper.sections import sections

DATA = "paper.json"
STANCES: dict[str, str] = {AGREES: "as in the paper", DIFFERS: "differs from the paper", BEYOND: "beyond the paper"}


def write_paper_report(document: PaperDocument, folder: Path) -> Path:
    """Write ``paper.json`` and the page ``index.html`` that shows the same numbers.

    Parameters
    ----------
    document : what :func:`reports.paper.reproduction.reproduce` returned; optional ``command``.
    folder : where both files go, each whole or not at all.

    Returns
    -------
    The path of the page.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    return write_experiments(
        folder,
        DATA,
        document,
        lambda _: sections(document),
        kicker="“FaceZip: Automatic Texture Compression for Facial Blendshapes”, reproduced on",
        title=f"{document.character.name} – the paper, reproduced by FaceZip",
        stances=STANCES,
    )
