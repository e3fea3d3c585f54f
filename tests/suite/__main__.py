"""``python -m tests.suite``: the plugin on a project that is not FaceZip's, as a new user has it.

A folder gets three test files: a scene of Mitsuba's own, a figure of matplotlib, an 8-bit picture. pytest writes their
references, compares equal images with other random numbers, and images with one defect each; nothing but its command
line is used, and nothing but ``results.json`` is read.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import click
from scipy import stats

from facezip.files.documents import read_document
from render.plugin.results import ImagesDocument, Result

PROJECT = Path(__file__).parent / "project"
DEFECTS = {
    "light 3 % dimmer": "scene",
    "box moved by a fiftieth of the room": "scene",
    "light paths of 3 instead of 8": "scene",
    "line wider by 0.2 points": "figure",
    "another digit at an axis": "figure",
    "a patch of 16 pixels two codes brighter": "picture",
    "one pixel to the right": "picture",
}
FILES = ("scene", "figure", "picture")


def measure(trials: int, defect_trials: int, defects: dict[str, str]) -> dict:
    """By file, equal images that failed; by defect, images that failed; each with its number and a 95 % interval."""
    with TemporaryDirectory() as place:
        project = Path(place)
        for name in FILES:
            shutil.copy(PROJECT / f"{name}.py", project / f"test_{name}.py")
        _pytest(project, "", trials, "--facezip-generate=all")
        equal = _pytest(project, "", trials)
        found = {defect: _pytest(project, defect, defect_trials, f"test_{of}.py") for defect, of in defects.items()}
    return {
        "equal": {name: _rate([one for one in equal if one.name.startswith(f"test_{name}.")]) for name in FILES},
        "all": _rate(equal),
        "least": min(one.comparison.probability for one in equal if one.comparison),
        "defects": {defect: {"of": defects[defect], **_rate(results)} for defect, results in found.items()},
    }


def _pytest(project: Path, defect: str, trials: int, *arguments: str) -> Sequence[Result]:
    """The results of a run, of which all tests have to have come to an end."""
    flags = ("-q", "-p", "no:cacheprovider", "--facezip-results=out", "--facezip-summary=json", "--facezip-allow-stale")
    environment = {**os.environ, "DEFECT": defect, "TRIALS": str(trials), "PYTHONWARNINGS": "ignore"}
    command = [sys.executable, "-m", "pytest", *flags, *arguments]
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(done.stdout + done.stderr)
    results = read_document(project / "out" / "results.json", ImagesDocument).results
    shutil.rmtree(project / "out")
    files = 1 if defect else len(FILES)
    if len(results) != files * trials:
        raise SystemExit(f"{len(results)} results of {files * trials} tests:\n{done.stdout}")
    return results


def _rate(results: Sequence[Result]) -> dict:
    count = sum(one.outcome == "failed" for one in results)
    interval = stats.binomtest(count, len(results)).proportion_ci(0.95, method="exact")
    return {"trials": len(results), "failed": count, "interval": [float(interval.low), float(interval.high)]}


@click.command()
@click.option("--trials", type=click.IntRange(min=1), default=334, show_default=True, help="Equal images of each file.")
@click.option("--defect-trials", type=click.IntRange(min=1), default=20, show_default=True, help="Of each defect.")
@click.option("--json", "as_json", is_flag=True, help="One document instead of lines.")
def main(trials: int, defect_trials: int, as_json: bool) -> None:
    """Measure false alarms and defects found on a foreign project."""
    document = measure(trials, min(defect_trials, trials), DEFECTS)
    if as_json:
        click.echo(json.dumps(document, indent=1))
        return
    rows = [(f"nothing changed, {name}", row) for name, row in document["equal"].items()]
    rows += [("nothing changed, together", document["all"])]
    rows += [(f"{row['of']}: {defect}", row) for defect, row in document["defects"].items()]
    for words, row in rows:
        low, high = row["interval"]
        shares = f"{100 * low:.2f} to {100 * high:.2f} %"
        click.echo(f"{words:<52} {row['failed']:4} of {row['trials']:4} failed  (95 % interval {shares})")
    click.echo(f"least p where nothing changed: {document['least']:.2g}")


if __name__ == "__main__":
    main()
