"""A page about experiments: its document as JSON, and the same numbers as findings, plots and tables."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from facezip.files.writing import write_whole
from reports.conditions import condition_rows
from reports.page import write_page
from reports.sections import Section
from reports.validation import strict

PAGE = "index.html"
Document = Mapping[str, Any]


def write_experiments(
    folder: Path,
    data_name: str,
    document: Document,
    sections: Callable[[Document], Sequence[Section]],
    *,
    kicker: str,
    title: str,
    stances: Mapping[str, str] | None = None,
) -> Path:
    """Write ``document`` as ``data_name``, and the page ``index.html`` that shows it; returns the page's path.

    Parameters
    ----------
    folder : where both files go, each whole or not at all.
    data_name, document : what is measured, with its ``findings``; values that are not finite become null.
    sections : the parts of the page, made of what is written.
    kicker, title : over the heading, and of the window.
    stances : words for where a finding stands to a claim.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    data = strict(document)
    write_whole(folder / data_name, json.dumps(data, indent=1, allow_nan=False).encode())
    return write_page(
        folder / PAGE,
        "experiments.html",
        document=data,
        data_name=data_name,
        kicker=kicker,
        title=title,
        sections=sections(data),
        conditions=condition_rows(data),
        stances=stances or {},
    )
