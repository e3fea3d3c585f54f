"""Less and less memory for one command: it is done, or ends with one clear line, and the old pack is there.

Warnings come when they are found, so some may stand above that line.
"""

import os
import resource
from collections import Counter
from pathlib import Path
from typing import NoReturn

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.files.packs import MANIFEST
from facezip.fit.pipeline import Request, compress_into
from tests.facezip.conftest import random_character
from tests.trust.children import command, in_child
from tests.trust.findings import Row
from tests.trust.kills import Packs

# Of check, too, which finds that random textures cannot be told.
DONE = (ExitCode.DONE, ExitCode.DIFFERENCE)
RUNGS, RUNG = 100, 2**19


def check_ladder(work: Path, part: float) -> list[Row]:
    """From next to no memory beside what the interpreter has with its kernels, by half a megabyte of addresses."""
    packs = Packs(work)
    scans = random_character(side=256, expressions=6)
    save_character(scans, work / "scans")
    # Kernels are loaded once, here: LLVM ends a process that has no memory for one.
    compress_into(work / "scans", work / "a.facezip", Request())
    verbs = {
        "compress": ["compress", work / "scans", "-o", packs.path, "--overwrite"],
        "check": ["check", work / "scans"],
    }
    return [_row(packs, work, verb, arguments, part) for verb, arguments in verbs.items()]


def _row(packs: Packs, work: Path, verb: str, arguments: list[object], part: float) -> Row:
    messages = work / "messages"
    in_child(lambda: command(arguments, messages))
    packs.manifests.append((packs.path / MANIFEST).read_bytes())
    faults, examples = Counter({"lost": 0, "leftovers after the next run": 0, "no clear error": 0}), []
    every, refused = max(1, round(1 / part)), 0
    rungs = range(1, RUNGS, every)
    for rung in rungs:
        outcome = in_child(lambda room=rung * RUNG: _with_room(arguments, messages, room))
        code = outcome.code
        said = messages.read_text(encoding="utf-8", errors="replace")
        refused += code == 3
        lost = packs.lost()
        packs.write(0)
        errors = [line for line in said.splitlines() if not line.startswith("facezip: warning: ")]
        clear = code in DONE or (code == 3 and len(errors) == 1 and "memory" in errors[0])
        found = {
            "lost": lost,
            "leftovers after the next run": ", ".join(packs.leftovers()),
            "no clear error": "" if clear else f"{code} {str(outcome.answer or said)[-200:]!r}",
        }
        for fault, words in found.items():
            if words:
                faults[fault] += 1
                examples.append(f"{rung * RUNG / 1e6:.0f} MB: {words}")
    # A ladder that is nowhere too low shows nothing.
    faults["none refused"] = int(refused == 0)
    return Row(f"rungs of memory for {verb}", len(rungs), faults, f"{refused} refused", tuple(examples))


def _with_room(arguments: list[object], messages: Path, room: int) -> NoReturn:
    """End this process as the command does that has so many bytes of addresses more than the process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + room
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    os._exit(command(arguments, messages))
