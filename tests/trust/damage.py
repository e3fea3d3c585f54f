"""Damaged packs: none is read as if nothing had happened, and each is refused in the one way."""

import os
import random
import shutil
from collections.abc import Callable, Iterator
from itertools import combinations
from pathlib import Path

from facezip import FaceZipError
from facezip.files.packs import MANIFEST
from facezip.pack.read import read_pack
from tests.trust import mutations
from tests.trust.children import in_child
from tests.trust.findings import Row

GOLDEN = Path(__file__).parent.parent / "data" / "pack-1" / "golden.facezip"
LAYERED = GOLDEN.parent.parent / "pack-2" / "golden.facezip"
MASKED = GOLDEN.parent.parent / "pack-3-masks" / "golden.facezip"
BATCH = 250

# Does something to a copy of the pack.
Damage = Callable[[Path], None]


def check_damage(work: Path, part: float) -> list[Row]:
    """All kinds of damage; ``part`` of 1 makes more than 10,000 packs of version 1, a fifth as many of either other."""
    rows = _check(work, part, GOLDEN, "packs with")
    rows += _check(work, part / 5, LAYERED, "packs of several maps with")
    return rows + _check(work, part / 5, MASKED, "packs of masks with")


def _check(work: Path, part: float, golden: Path, what: str) -> list[Row]:
    files = {file.name: file.read_bytes() for file in sorted(golden.iterdir())}
    pictures = {name: content for name, content in files.items() if name.endswith(".png")}
    manifest = files[MANIFEST]
    step = max(1, round(1 / part))
    kinds: dict[str, list[Damage]] = {
        "single bits flipped": _mutants(files, mutations.flip_bit, round(3000 * part)),
        "prefixes of the manifest": [_replaced(MANIFEST, manifest[:n]) for n in range(0, len(manifest), step)],
        "images cut off": _mutants(pictures, mutations.truncate, round(1000 * part)),
        "windows overwritten": _mutants(files, mutations.overwrite_window, round(3000 * part)),
        "headers changed": _mutants(files, mutations.mutate_header, round(1000 * part)),
        "tails appended": _mutants(files, mutations.append_tail, max(9, round(100 * part))),
        "files renamed, swapped, missing, added, linked": list(_misplaced(files)),
    }
    return [_row(f"{what} {kind}", work, golden, damages) for kind, damages in kinds.items()]


def _mutants(files: dict[str, bytes], mutation: mutations.Mutation, count: int) -> list[Damage]:
    """Equally many of each file: a manifest counts as much as an image a hundred times its size."""
    rng, names = random.Random(mutation.__name__), sorted(files)
    damages: list[Damage] = []
    while len(damages) < count:
        name = names[len(damages) % len(names)]
        changed = mutation(rng, files[name])
        if changed != files[name]:
            damages.append(_replaced(name, changed))
    return damages


def _replaced(name: str, content: bytes) -> Damage:
    def damage(pack: Path) -> None:
        (pack / name).write_bytes(content)

    return damage


def _misplaced(files: dict[str, bytes]) -> Iterator[Damage]:
    for name in files:
        yield lambda pack, name=name: (pack / name).unlink()
        yield lambda pack, name=name: _move(pack / name, pack / f"{name}.bak")
        yield lambda pack, name=name: _move(pack / name, pack / name.upper())
        yield lambda pack, name=name: _linked(pack / name)
        yield lambda pack, name=name: _made_folder(pack / name)
        yield lambda pack, name=name: _made_fifo(pack / name)
        yield lambda pack, name=name: shutil.copy(pack / name, pack / f"copy of {name}")
    for a, b in list(combinations(files, 2))[:200]:
        yield lambda pack, a=a, b=b: _swap(pack / a, pack / b)
    for extra in (".hidden", "notes.txt", "difference_4.png", "weights_1.png", "__init__.py", "pickle.pkl"):
        yield _replaced(extra, b"")
    yield lambda pack: (pack / "folder").mkdir()
    yield lambda pack: os.symlink("/etc/passwd", pack / "passwd")


def _move(old: Path, new: Path) -> None:
    old.rename(new)


def _linked(file: Path) -> None:
    file.rename(file.parent.parent / "elsewhere")
    file.symlink_to(file.parent.parent / "elsewhere")


def _made_folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


def _made_fifo(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)


def _swap(a: Path, b: Path) -> None:
    content = a.read_bytes()
    a.write_bytes(b.read_bytes())
    b.write_bytes(content)


def _row(what: str, work: Path, golden: Path, damages: list[Damage]) -> Row:
    faults = {"silently accepted": 0, "other exceptions": 0, "crashes or hangs": 0}
    examples: list[str] = []
    for first in range(0, len(damages), BATCH):
        batch = damages[first : first + BATCH]
        outcome = in_child(lambda batch=batch: [_verdict(work, golden, damage) for damage in batch], limit=120)
        # A batch that died is gone through one by one, to know which.
        single = outcome.answer if outcome.code == 0 else [_alone(work, golden, damage) for damage in batch]
        for number, fault in enumerate(single, first):
            if fault:
                faults[fault.split(":")[0]] += 1
                examples.append(f"case {number}: {fault}")
    return Row(what, len(damages), faults, examples=tuple(examples))


def _alone(work: Path, golden: Path, damage: Damage) -> str:
    outcome = in_child(lambda: _verdict(work, golden, damage), limit=10)
    return str(outcome.answer) if outcome.code == 0 else f"crashes or hangs: {outcome.code}"


def _verdict(work: Path, golden: Path, damage: Damage) -> str:
    shutil.rmtree(work / "damaged", ignore_errors=True)
    pack = work / "damaged" / "golden.facezip"
    shutil.copytree(golden, pack)
    damage(pack)
    try:
        read_pack(pack)
    except FaceZipError:
        return ""
    except BaseException as error:
        return f"other exceptions: {error!r}"
    return "silently accepted"
