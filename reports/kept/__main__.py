"""Measures the kept figures anew, and writes them into the documentation: a few minutes.

python -m reports.kept                          # benchmarks/results.csv, and the numbers of README.md and docs/
python -m reports.kept --large                  # 1024² and 2048² too
python -m reports.kept --only capture_a         # one character
python -m reports.kept --pages                  # measures nothing: only the numbers of the pages

Rows that are not measured stay as they are: those of captures that are not here, and of large sizes.
"""

import sys
from pathlib import Path

import click

from facezip.character.loading import load_character
from facezip.files.writing import write_whole
from facezip.machine.progress import show_progress
from reports.kept.measure import LARGE, USUAL, Subject, measure
from reports.kept.pages import pages, renewed
from reports.kept.rows import read_rows, write_rows
from reports.site import ROOT

RESULTS = ROOT / "benchmarks" / "results.csv"
CAPTURES = ROOT.parent / "shared" / "data"
FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command(help=__doc__)
@click.option("--captures", type=FOLDER, default=CAPTURES, help="Folder of folders of scans that are not ours to ship.")
@click.option("--large", is_flag=True, help="Measure large sizes too.")
@click.option("--only", metavar="NAME", help="Measure one character, at all its sizes.")
@click.option("--pages", "pages_only", is_flag=True, help="Measure nothing.")
def command(captures: Path, large: bool, only: str | None, pages_only: bool) -> None:
    """Measure, then write the file and the pages."""
    rows = read_rows(RESULTS)
    if not pages_only:
        subjects = [*USUAL, *(LARGE if large else ()), *_captured(captures)]
        chosen = [subject for subject in subjects if only in (None, subject.name)]
        with show_progress():
            for row in measure(chosen):
                rows[row.key] = row
                write_rows(RESULTS, rows.values())
                print(f"{row.key}: RMSE {row.rmse:.2f}", file=sys.stderr, flush=True)
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if (new := renewed(text, rows)) != text:
            write_whole(page, new.encode())
            print(f"{page.relative_to(ROOT)}: new numbers", file=sys.stderr)


def _captured(folder: Path) -> list[Subject]:
    """The captures in a folder; none where there is no such folder."""
    found = sorted(path.parent for path in folder.glob("*/neutral.obj"))
    return [Subject(path.name, load_character(path).first.resolution[1], folder=path) for path in found]


if __name__ == "__main__":
    command()
