"""The system refuses the k-th call of a writer, or of a reader, for every k: one clear error, and nothing is lost."""

import os
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from facezip import FaceZipError
from facezip.pack.read import read_pack
from tests.trust.findings import Row
from tests.trust.kills import Packs
from tests.trust.system_calls import CHANGES, MISSING, READS, calls_in, may_trace, traced

REFUSALS = ("EIO", "ENOSPC", "EDQUOT", "EACCES")
DONE, CLEAR, WRONG, UNCLEAR = 0, 3, 4, 5


def check_refusals(work: Path, part: float) -> list[Row]:
    """Each call that concerns the pack, once with each refusal."""
    rows = {"writing": (CHANGES, REFUSALS), "reading": (READS, REFUSALS[::3])}
    if not may_trace():
        return [Row(f"k-th call of {what} fails", 0, skipped=MISSING) for what in rows]
    packs, cores = Packs(work), os.sched_getaffinity(0)
    # On one core calls come in one order.
    os.sched_setaffinity(0, {min(cores)})
    try:
        return [_row(packs, work / f"{what}.log", what, *how, part) for what, how in rows.items()]
    finally:
        os.sched_setaffinity(0, cores)


def _row(packs: Packs, log: Path, what: str, calls: tuple[str, ...], refusals: tuple[str, ...], part: float) -> Row:
    faults, examples = (
        Counter({"lost": 0, "leftovers after the next run": 0, "no clear error": 0, "wrong result": 0}),
        [],
    )
    message, every, cases, refused = log.with_suffix(".message"), max(1, round(1 / part)), 0, 0
    act = _written if what == "writing" else _read
    for number, (name, k) in enumerate(_places(packs, log, calls, act, message)):
        for refusal in refusals if number % every == 0 else ():
            code = traced(lambda: act(packs, message), log, (name,), "-e", f"inject={name}:error={refusal}:when={k}")
            cases, refused = cases + 1, refused + (code == CLEAR)
            for fault, found in _found(packs, code, message).items():
                if found:
                    faults[fault] += 1
                    examples.append(f"{refusal} of {name} {k}: {found}")
    return Row(f"k-th call of {what} fails", cases, faults, f"{refused} refused", tuple(examples))


def _places(
    packs: Packs, log: Path, calls: tuple[str, ...], act: Callable[[Packs, Path], None], message: Path
) -> Iterator[tuple[str, int]]:
    """The calls that concern the pack: name, and how many of that name the thread has made by then."""
    code = traced(lambda: act(packs, message), log, calls)
    if code != DONE:
        raise RuntimeError(f"what is to be refused has failed with {code}")
    made: Counter[tuple[int, str]] = Counter()
    found: dict[tuple[str, int], None] = {}
    for call in list(calls_in(log)):
        made[call.thread, call.name] += 1
        paths = [call.path(place) for place in range(min(4, len(call.arguments)))]
        if any(path is not None and path.is_relative_to(packs.folder) for path in paths):
            found[call.name, made[call.thread, call.name]] = None
    packs.write(0)
    yield from found


def _written(packs: Packs, message: Path) -> None:
    _answer(lambda: packs.write(1), message)


def _read(packs: Packs, message: Path) -> None:
    expected = packs.models[0].expressions

    def read() -> None:
        if read_pack(packs.path).expressions != expected:
            os._exit(WRONG)

    _answer(read, message)


def _answer(work: Callable[[], None], message: Path) -> None:
    """End this process with what became of the work; what it says may itself be refused, once."""
    try:
        work()
        code, words = DONE, ""
    except FaceZipError as error:
        words = str(error)
        code = CLEAR if len(words.splitlines()) == 1 and ".tmp" not in words else UNCLEAR
    except BaseException as error:
        code, words = UNCLEAR, repr(error)
    for _ in range(2):
        try:
            message.write_text(words, encoding="utf-8")
            break
        except OSError:
            continue
    os._exit(code)


def _found(packs: Packs, code: int, message: Path) -> dict[str, str]:
    """What is wrong after a refusal, by fault."""
    words = message.read_text(encoding="utf-8")
    lost = packs.lost()
    packs.write(0)
    return {
        "lost": lost,
        "leftovers after the next run": ", ".join(packs.leftovers()),
        "no clear error": "" if code in (DONE, CLEAR, WRONG) else f"{code} {words}",
        "wrong result": "read otherwise" if code == WRONG else "",
    }
