"""The power fails while a pack is overwritten: in every state in which the disk may then be, old or new is there."""

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

from tests.trust.disks import Disk, lay_out, states
from tests.trust.findings import Row
from tests.trust.kills import Packs, without_exchange
from tests.trust.replay import replay
from tests.trust.system_calls import CHANGES, MISSING, calls_in, may_trace, traced


def check_power(work: Path, part: float) -> list[Row]:
    """Every state after every step of an overwriting, by exchange of names and by renames, and of a first writing."""
    whats = {"overwriting, names exchanged": True, "overwriting, without exchange": True, "writing a new pack": False}
    if not may_trace():
        return [Row(f"power cut while {what}", 0, skipped=MISSING) for what in whats]
    return [_row(work / str(n), what, there, part) for n, (what, there) in enumerate(whats.items())]


def _row(work: Path, what: str, there: bool, part: float) -> Row:
    packs = Packs(work)
    if not there:
        shutil.rmtree(packs.path)
    disk = Disk(packs.folder)
    write: Callable[[], None] = partial(packs.write, 1)
    code = traced(partial(without_exchange, write) if "without" in what else write, work / "log", CHANGES)
    replay(calls_in(work / "log"), packs.folder, disk)
    if code or packs.leftovers():
        raise RuntimeError(f"what is to be cut short has failed with {code}")
    faults, examples, cases = {"lost": 0, "not durable": 0, "leftovers after the next run": 0}, [], 0
    every = max(1, round(1 / part))
    for number, (cut, case, state) in enumerate(states(disk)):
        if number % every:
            continue
        cases += 1
        here = packs.at(work / "cut")
        lay_out(state, here.folder)
        for fault, found in _found(here, there, cut == len(disk.steps)).items():
            if found:
                faults[fault] += 1
                examples.append(f"{case}: {found}")
        shutil.rmtree(here.folder)
    return Row(f"power cut while {what}", cases, faults, f"{len(disk.steps)} steps", tuple(examples))


def _found(packs: Packs, there: bool, done: bool) -> dict[str, str]:
    """What is wrong with a state, by fault."""
    absent = not there and not packs.path.exists()
    lost = "" if absent else packs.lost()
    durable = not done or (not absent and packs.holds(1))
    packs.write(0)
    return {
        "lost": lost or packs.lost(),
        "not durable": "" if durable else "the new pack is not there after it was done",
        "leftovers after the next run": ", ".join(packs.leftovers()),
    }
