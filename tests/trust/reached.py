"""Which lines of facezip's readers the corpus reaches: ``python -m tests.trust.reached``.

Kernels do not count: they are compiled, and no Python runs them.
"""

import tempfile
from pathlib import Path

import coverage

from tests.trust.guided import CORPUS, unpack

PACKAGES = ["facezip.files", "facezip.pack", "facezip.character"]


def main() -> None:
    lines = coverage.Coverage(data_file=None, source_pkgs=PACKAGES, config_file=False)
    lines.exclude("@njit")
    lines.start()
    from tests.trust import fuzz

    unpack(CORPUS)
    count = 0
    with tempfile.TemporaryDirectory() as work:
        for reader, every in fuzz.make_corpus(Path(work)).items():
            files = fuzz.different(every)
            for file in files:
                fuzz.finding(reader, file)
            for kept in sorted((CORPUS / reader).glob("*")):
                fuzz.try_bytes(reader, *fuzz.parted(files, kept.read_bytes()))
                count += 1
    lines.stop()
    print(f"{count} inputs in the corpus")
    lines.report(sort="Cover")


if __name__ == "__main__":
    main()
