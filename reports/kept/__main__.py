"""Measures the kept figures anew, and writes them into the documentation: minutes.

python -m reports.kept                          # benchmarks/*.csv, and the numbers of README.md and docs/
python -m reports.kept --large                  # sizes from 1024² to 8192² too: hours
python -m reports.kept --only capture_a         # one character, or one benchmark
python -m reports.kept --again                  # what is up to date, too
python -m reports.kept --pages                  # measures nothing: only the numbers of the pages

A figure is measured where the code, the scans or the libraries that it depends on have changed since, so a run that was
stopped goes on where it was. Figures that are not measured stay as they are: those of captures that are not here, and
of large sizes.
"""

import sys
from pathlib import Path
from time import perf_counter

import click

from facezip.character.loading import load_character
from facezip.files.writing import write_whole
from facezip.machine.progress import show_progress
from reports.kept.answers import Question, ask, questions, read_figures, unanswered, write_figures
from reports.kept.measure import FIRST, LARGE, USUAL, Subject, measure, stale
from reports.kept.pages import pages, renewed
from reports.kept.rows import read_rows, write_rows
from reports.site import ROOT

RESULTS, ANSWERS = ROOT / "benchmarks" / "results.csv", ROOT / "benchmarks" / "answers.csv"
CAPTURES = ROOT.parent / "shared" / "data"
FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command(help=__doc__)
@click.option("--captures", type=FOLDER, default=CAPTURES, help="Folder of folders of scans that are not ours to ship.")
@click.option("--large", is_flag=True, help="Measure large sizes too.")
@click.option("--only", metavar="NAME", help="Measure one character, at all its sizes, or one benchmark.")
@click.option("--again", is_flag=True, help="Measure what is up to date, too.")
@click.option("--pages", "pages_only", is_flag=True, help="Measure nothing.")
def command(captures: Path, large: bool, only: str | None, again: bool, pages_only: bool) -> None:
    """Measure, then write the files and the pages."""
    if not pages_only:
        captured = sorted(path.parent for path in captures.glob("*/neutral.obj"))
        with show_progress():
            _measure([FIRST, *USUAL, *map(_captured, captured), *(LARGE if large else ())], only, again)
            _ask(questions(captured), only, again)
    rows, figures = read_rows(RESULTS), read_figures(ANSWERS)
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if (new := renewed(text, rows, figures)) != text:
            write_whole(page, new.encode())
            print(f"{page.relative_to(ROOT)}: new numbers", file=sys.stderr)


def _measure(subjects: list[Subject], only: str | None, again: bool) -> None:
    """Rows are written one by one: what is measured is kept, whatever ends the run."""
    rows = read_rows(RESULTS)
    chosen = [subject for subject in subjects if only in (None, subject.name)]
    begin = perf_counter()
    for row in measure(chosen if again else [stale(subject, rows) for subject in chosen]):
        rows[row.key] = row
        write_rows(RESULTS, rows.values())
        spread = f", cpu {row.cpu:.1f} within {row.cpu_spread:.0%}" if row.cpu and row.cpu_spread is not None else ""
        print(f"{row.key}: RMSE {row.rmse:.2f}{spread} ({perf_counter() - begin:.0f} s)", file=sys.stderr, flush=True)
        begin = perf_counter()


def _ask(asked: list[Question], only: str | None, again: bool) -> None:
    """As :func:`_measure`; an answer replaces all figures of the one before."""
    figures = read_figures(ANSWERS)
    chosen = [one for one in asked if only in (None, one.name)]
    chosen = chosen if again else unanswered(chosen, figures)
    begin = perf_counter()
    for question, found in ask(chosen):
        kept = [figure for figure in figures.values() if figure.key.partition("/")[0] != question.name]
        figures = {figure.key: figure for figure in (*kept, *found)}
        write_figures(ANSWERS, list(figures.values()))
        print(f"{question.name}: {question.command} ({perf_counter() - begin:.0f} s)", file=sys.stderr, flush=True)
        begin = perf_counter()


def _captured(folder: Path) -> Subject:
    return Subject(folder.name, load_character(folder).first.resolution[1], folder=folder)


if __name__ == "__main__":
    command()
