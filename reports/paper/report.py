"""The report of ``facezip paper``: findings first, then the paper's table and figures, every number in its JSON."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from facezip.writing import write_whole
from reports.conditions import condition_rows
from reports.page import write_page
from reports.paper.findings import AGREES, BEYOND, DIFFERS
from reports.paper.sections import sections
from reports.validation import strict

PAGE, DATA = "index.html", "paper.json"
STANCES = {AGREES: "as in the paper", DIFFERS: "differs from the paper", BEYOND: "beyond the paper"}


def write_paper_report(document: Mapping[str, Any], folder: Path) -> Path:
    """Write ``paper.json`` and the page ``index.html`` that shows the same numbers.

    Parameters
    ----------
    document : what :func:`reports.paper.reproduction.reproduce` returned (``facezip-paper/1``); optional ``command``.
    folder : where both files go, each whole or not at all.

    Returns
    -------
    The path of the page.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    data = strict(document)
    write_whole(folder / DATA, json.dumps(data, indent=1, allow_nan=False).encode())
    return write_page(
        folder / PAGE,
        "experiments.html",
        document=data,
        data_name=DATA,
        kicker="“FaceZip: Automatic Texture Compression for Facial Blendshapes”, reproduced on",
        title=f"{data['character']['name']} – the paper, reproduced by FaceZip",
        sections=sections(data),
        conditions=condition_rows(data),
        stances=STANCES,
    )
