"""Tests of the tests: ``python -m tests.mutation [--alive] [--sample 100] [MODULE ...]``.

Each mutant of a module runs the tests of that module, the quickest first, until one fails. One that none of them
notices gets a test, or a reason in ``tests/mutation/survivors.toml`` why it changes nothing that is promised. The exit
code is 1 where one has neither, where fewer than nine of ten are killed, and where the list has one that no longer is.
"""

import argparse
import json
import random
import sys
import tomllib
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from tests.mutation.operators import Mutant, mutants
from tests.mutation.replacing import file_of
from tests.mutation.trial import try_all

PACK = [f"tests/facezip/pack/{name}.py" for name in ("test_manifest", "test_golden", "test_packs")]
SWEEP = [
    "tests/facezip/fit/test_sweep.py",
    "tests/facezip/fit/test_locks.py::test_textures_around_locked_ones_are_least_squares",
    "tests/facezip/fit/test_joint.py::test_joint_equations_are_the_sum_of_each_maps",
]
# Each module, and the tests that hold it.
TESTS = {
    "facezip.pack.manifest": PACK,
    "facezip.pack.parsing": [*PACK, "tests/conformance/test_conformance.py::test_the_library_says_what_is_expected"],
    "facezip.pack.checks": ["tests/facezip/pack/test_checks.py", *PACK[:1]],
    "facezip.pack.verification": [
        "tests/facezip/pack/test_packs.py",
        "tests/facezip/files/test_pointers.py::test_a_file_of_a_pack",
    ],
    "facezip.pack.quantise": ["tests/facezip/pack/test_quantise.py", *PACK[1:]],
    "facezip.fit.sweep": SWEEP,
    "facezip.fit.passes": SWEEP,
    "render.decision": ["tests/render/test_decision.py"],
    "render.plugin.statistics": ["tests/render/plugin/test_statistics.py"],
}
SURVIVORS = Path(__file__).with_name("survivors.toml")
# What the last run found: by module and mutant the test that failed, "" where none did.
FOUND = Path("out/mutation.json")
# The least part that tests have to notice.
KILLED = 0.9

Found = dict[str, dict[str, str]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", default=[*TESTS], help=", ".join(TESTS))
    parser.add_argument("--sample", type=int, help="so many mutants of each module, drawn at random, not all")
    parser.add_argument("--alive", action="store_true", help="only those that the last run left alive without a reason")
    options = parser.parse_args()
    known: Found = tomllib.loads(SURVIVORS.read_text(encoding="utf-8"))
    found: Found = json.loads(FOUND.read_text(encoding="utf-8")) if FOUND.is_file() else {}
    if unknown := known.keys() - TESTS:
        sys.exit(f"{SURVIVORS}: no module here: {', '.join(unknown)}")
    faults, lines = 0, []
    for module in options.modules:
        every = {mutant.name: mutant for mutant in mutants(file_of(module).read_text(encoding="utf-8"))}
        before = {name: test for name, test in found.get(module, {}).items() if name in every and options.alive}
        reasons = known.get(module, {})
        drawn = [mutant for name, mutant in every.items() if not (before.get(name) or name in before.keys() & reasons)]
        if options.sample is not None:
            drawn = random.Random(0).sample(drawn, min(options.sample, len(drawn)))
        found[module] = before
        try_all(module, drawn, TESTS[module], partial(_keep, found, module))
        words, line = _judged(module, every, found[module], reasons)
        faults += len(words)
        lines.append(line)
        for each in words:
            print(each, flush=True)
    print("\n".join(["| module | mutants | killed | explained | share |", "|---|---|---|---|---|", *lines]))
    sys.exit(1 if faults else 0)


def _judged(
    module: str, every: Mapping[str, Mutant], tried: Mapping[str, str], reasons: Mapping[str, str]
) -> tuple[list[str], str]:
    """What is wrong, and the module's line of the table."""
    alive = [name for name, test in tried.items() if not test]
    explained = [name for name in alive if name in reasons]
    killed, part = len(tried) - len(alive), 1 - len(alive) / max(len(tried), 1)
    wrong = [f"{file_of(module)}:{every[name].line}: NOT EXPLAINED: {name}" for name in alive if name not in reasons]
    wrong += [f"{SURVIVORS}: NOT ALIVE: {name}" for name in reasons if name not in every or tried.get(name)]
    wrong += [f"{module}: FEWER THAN {KILLED:.0%} KILLED"] if part < KILLED else []
    count = len(every) if len(tried) == len(every) else f"{len(tried)} of {len(every)}"
    return wrong, f"| `{module}` | {count} | {killed} | {len(explained)} | {part:.0%} |"


def _keep(found: Found, module: str, mutant: str, test: str) -> None:
    """After each one, so that a run that was cut off can go on."""
    found[module][mutant] = test
    FOUND.parent.mkdir(exist_ok=True)
    part = FOUND.with_suffix(".part")
    part.write_text(json.dumps(found, indent=1, ensure_ascii=False), encoding="utf-8")
    part.replace(FOUND)


if __name__ == "__main__":
    main()
