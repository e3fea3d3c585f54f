"""``make trust``: what damage, kills, claims, names and mutants do to FaceZip, as one table.

``python -m tests.trust [--part 0.1] [--only kills claims]``; the exit code is 1 where a line of the table fails.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.trust.claims import check_claims
from tests.trust.contention import check_contention
from tests.trust.damage import check_damage
from tests.trust.findings import Row
from tests.trust.fuzz import check_fuzz
from tests.trust.guided import check_guided
from tests.trust.kills import check_kills
from tests.trust.ladder import check_ladder
from tests.trust.meshes import check_meshes
from tests.trust.mutants import check_mutants
from tests.trust.names import check_names
from tests.trust.power import check_power
from tests.trust.refusals import check_refusals
from tests.trust.same import check_same

CHECKS: dict[str, Callable[[Path, float], list[Row]]] = {
    "damage": check_damage,
    "kills": check_kills,
    "power": check_power,
    "refusals": check_refusals,
    "ladder": check_ladder,
    "contention": check_contention,
    "claims": check_claims,
    "names": check_names,
    "mutants": check_mutants,
    "meshes": check_meshes,
    "same": check_same,
    "fuzz": check_fuzz,
    "guided": check_guided,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", type=float, default=1, help="of the cases, where they can be fewer")
    parser.add_argument("--only", nargs="+", choices=CHECKS, default=list(CHECKS))
    options = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as work:
        for name in options.only:
            start = time.perf_counter()
            (Path(work) / name).mkdir()
            rows = CHECKS[name](Path(work) / name, options.part)
            print(f"{name}  ({time.perf_counter() - start:.0f} s)", *rows, sep="\n", flush=True)
            failed += sum(not (row.passed or row.skipped) for row in rows)
    print("all as promised" if not failed else f"{failed} lines FAIL")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
