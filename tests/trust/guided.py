"""The readers under bytes that coverage guides: ``python -m tests.trust.guided [--seconds 600 | --inputs 8000]``.

atheris changes inputs, and keeps each that takes a branch of facezip that none before it took. What it keeps lies in
``out/corpus/READER``. The next run starts from there, from the corpus that is committed and from the small valid files
of :mod:`tests.trust.fuzz`, where it also says what a finding is. ``--commit`` puts the corpus into the committed one.
"""

import argparse
import re
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from tests.trust.findings import Row

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "tests" / "data" / "corpus.zip"
CORPUS, FOUND = Path("out") / "corpus", Path("out") / "fuzz"
RUNS = 1000
# In bytes: what is larger is one of the valid files with a change that a smaller input has too.
LARGEST = 4096
MISSING = "atheris is not installed; it is an extra of facezip, fuzz"
# A reader ends where an input takes 30 s, or where the process comes to hold 3 GB.
LIMITS = ("-timeout=30", "-rss_limit_mb=3000", "-max_len=65536", "-len_control=0", "-print_final_stats=1")


def check_guided(work: Path, part: float) -> list[Row]:
    """A fixed number of inputs for each reader, from the corpus that is committed on."""
    if find_spec("atheris") is None:
        return [Row("inputs that coverage guides", 0, skipped=MISSING)]
    unpack(work)
    return fuzz(readers(), work, f"-runs={round(RUNS * part)}", "-seed=1")


def readers() -> list[str]:
    """Names of those that :mod:`tests.trust.fuzz` knows, asked for elsewhere: here facezip is not imported."""
    return _python("from tests.trust.fuzz import READERS; print(*READERS, sep='\\n')").stdout.splitlines()


def unpack(into: Path) -> None:
    """The corpus that is committed, one folder a reader."""
    with zipfile.ZipFile(KEPT) as kept:
        kept.extractall(into)


def commit(folder: Path) -> None:
    """Commit the corpus: the same bytes for the same inputs."""
    with zipfile.ZipFile(KEPT, "w") as kept:
        for file in sorted(path for path in folder.rglob("*") if path.is_file() and path.stat().st_size <= LARGEST):
            entry = zipfile.ZipInfo(file.relative_to(folder).as_posix())
            kept.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED, 9)


def fuzz(names: Sequence[str], corpus: Path, *options: str) -> list[Row]:
    """Fuzz readers, each from the inputs in ``corpus / reader`` on, to which it adds."""
    for name in names:
        (corpus / name).mkdir(exist_ok=True, parents=True)
    FOUND.mkdir(exist_ok=True, parents=True)
    before = {*FOUND.iterdir()}
    call = "from tests.trust.guided_child import main; main()"
    done = _python(call, ",".join(names), str(corpus), str(FOUND), *LIMITS, *options)
    if done.returncode:
        return [Row("inputs that coverage guides", 0, examples=(done.stderr[-400:],))]
    found = sorted({*FOUND.iterdir()} - before)
    return [
        _row(name, corpus, [file for file in found if re.match(f"([0-9a-f]{{12}}-)?{name}-", file.name)])
        for name in names
    ]


def _row(name: str, corpus: Path, found: Sequence[Path]) -> Row:
    log = (FOUND / f"{name}.log").read_text("utf-8", errors="replace")
    counted = re.search(r"number_of_executed_units: *(\d+)", log)
    return Row(
        f"inputs of the {name} reader, guided by coverage",
        int(counted[1]) if counted else 0,
        {"findings": len(found)},
        notes=f"{sum(1 for _ in (corpus / name).iterdir())} in the corpus",
        examples=(*map(str, found), *([] if counted else [log[-400:]])),
    )


def _python(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    call = [sys.executable, "-c", program, *arguments]
    return subprocess.run(call, capture_output=True, text=True, errors="replace", check=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readers", nargs="*", metavar="READER", default=readers())
    parser.add_argument("--seconds", type=int, default=60, help="for each reader")
    parser.add_argument("--inputs", type=int, help="of each reader, instead of so many seconds")
    parser.add_argument("--seed", type=int, help="of the changes, as of libFuzzer; the table's is 1  [default: any]")
    parser.add_argument("--commit", action="store_true", help="the corpus, after that")
    options = parser.parse_args()
    unpack(CORPUS)
    passed = True
    until = f"-max_total_time={options.seconds}" if options.inputs is None else f"-runs={options.inputs}"
    seed = [] if options.seed is None else [f"-seed={options.seed}"]
    for name in options.readers:
        for row in fuzz([name], CORPUS, until, *seed):
            print(row, flush=True)
            passed &= row.passed
    if options.commit:
        commit(CORPUS)
    sys.exit(0 if passed else 1)


if __name__ == "__main__":
    main()
