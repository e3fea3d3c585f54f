"""A page about experiments: its document as JSON, and the same numbers as findings, plots and tables."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from facezip.documents.document import Data, Document, plain, to_json
from facezip.files.writing import write_whole
from reports.conditions import condition_rows
from reports.page import write_page
from reports.sections import Section

PAGE = "index.html"


def write_experiments(
    folder: Path,
    data_name: str,
    document: Document,
    sections: Callable[[Data], Sequence[Section]],
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
    data = plain(document)
    write_whole(folder / data_name, to_json(document).encode())
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
