"""Writers that are killed, interrupted or refused by the disk: the old pack or the new one is there, whole."""

import contextlib
import copy
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from facezip import FaceZipError, compress
from facezip.character.loading import save_character
from facezip.errors import ErrorCode
from facezip.files import renaming
from facezip.files.packs import MANIFEST
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_character, random_model
from tests.trust.children import command, in_child, start_child
from tests.trust.findings import Row

NOBODY = 65534


def check_kills(work: Path, part: float) -> list[Row]:
    """200 random kills, half of them where names cannot be exchanged, and one at every rename."""
    return [
        _random_kills(work / "exchange", max(3, round(100 * part)), _overwrite_for_ever),
        _random_kills(
            work / "renames", max(3, round(100 * part)), lambda packs: without_exchange(_overwrite_for_ever, packs)
        ),
        _kills_at_each_rename(work / "points"),
        _full_disk(work / "disk", max(3, round(40 * part))),
        _read_only_mount(work / "mounted"),
        _read_only_folder(),
        _interrupts(work / "interrupts", max(6, round(20 * part))),
    ]


class Packs:
    """A pack at ``path`` that is overwritten by turns with one of two models, whose manifests are known."""

    def __init__(self, work: Path) -> None:
        self.folder = work / "here"
        self.folder.mkdir(parents=True)
        self.path = self.folder / "me.facezip"
        self.models = [random_model(seed, size=(96, 96), weights=(12, 12), meshes=True) for seed in (1, 2)]
        self.manifests = []
        for number, model in enumerate(self.models):
            write_pack(model, work / f"{number}.facezip", name="me")
            self.manifests.append((work / f"{number}.facezip" / MANIFEST).read_bytes())
        self.write(0)

    def at(self, folder: Path) -> "Packs":
        """The same packs, of which one lies in another folder."""
        other = copy.copy(self)
        other.folder, other.path = folder, folder / self.path.name
        return other

    def write(self, number: int) -> None:
        write_pack(self.models[number], self.path, name="me", overwrite=True)

    def lost(self) -> str:
        """What is wrong with the pack, if anything: it must read, and be one of the two."""
        try:
            read_pack(self.path)
            known = (self.path / MANIFEST).read_bytes() in self.manifests
        except (FaceZipError, OSError) as error:
            return str(error)
        return "" if known else "neither the old nor the new pack"

    def holds(self, number: int) -> bool:
        """Whether it is the pack of that number."""
        return (self.path / MANIFEST).read_bytes() == self.manifests[number]

    def leftovers(self) -> list[str]:
        return sorted(entry.name for entry in self.folder.iterdir() if entry != self.path)


def _random_kills(work: Path, count: int, write: Callable[[Packs], None]) -> Row:
    packs, rng = Packs(work), random.Random(0)
    start = time.perf_counter()
    packs.write(1)
    typical = time.perf_counter() - start
    faults, examples, interrupted = {"lost": 0, "leftovers after the next run": 0}, [], 0
    for number in range(count):
        child = start_child(lambda: write(packs))
        time.sleep(rng.uniform(0.5, 4) * typical)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        interrupted += bool(packs.leftovers())
        _judge(packs, f"kill {number}", faults, examples)
    how = "names exchanged" if write is _overwrite_for_ever else "without exchange"
    return Row(
        f"kill -9 while overwriting, {how}", count, faults, f"{interrupted} left something behind", tuple(examples)
    )


def _judge(packs: Packs, case: str, faults: dict[str, int], examples: list[str]) -> None:
    """Old or new at once; nothing else after the next run."""
    lost = packs.lost()
    packs.write(0)
    leftovers = packs.leftovers()
    for fault, found in zip(("lost", "leftovers after the next run"), (lost or packs.lost(), leftovers), strict=True):
        if found:
            faults[fault] += 1
            examples.append(f"{case}: {found}")


def _overwrite_for_ever(packs: Packs) -> None:
    while True:
        for number in (1, 0):
            packs.write(number)


def without_exchange(write: Callable[..., None], *given: Any) -> None:
    """Write in this process, whose system cannot exchange names."""
    renaming.exchange = lambda *_: False
    write(*given)


def _kills_at_each_rename(work: Path) -> Row:
    """The moments that random kills hardly hit: right before and right after each change of a name."""
    packs = Packs(work)
    faults, examples, cases = {"lost": 0, "leftovers after the next run": 0}, [], 0
    for exchanging in (True, False):
        for moment in range(2 * (1 if exchanging else 3)):
            child = start_child(lambda e=exchanging, m=moment: _die_at(packs, e, m))
            _, status = os.waitpid(child, 0)
            case = f"moment {moment} with{'' if exchanging else 'out'} exchange"
            if os.waitstatus_to_exitcode(status) != -signal.SIGKILL:
                examples.append(f"{case}: not reached")
                faults["lost"] += 1
            cases += 1
            _judge(packs, case, faults, examples)
    return Row("kill -9 right before and after each rename", cases, faults, examples=tuple(examples))


def _die_at(packs: Packs, exchanging: bool, moment: int) -> None:
    left = moment

    def deadly(change: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*names: Any) -> Any:
            nonlocal left
            for act in (lambda: None, lambda: change(*names)):
                done = act()
                if left == 0:
                    os.kill(os.getpid(), signal.SIGKILL)
                left -= 1
            return done

        return counted

    if exchanging:
        renaming.exchange = deadly(renaming.exchange)
    else:
        renaming.exchange = lambda *_: False
        os.rename = deadly(os.rename)
    packs.write(1)


def _full_disk(work: Path, count: int) -> Row:
    """A disk with room for less and less of the new pack."""
    what = "full disk"
    with _tmpfs(work) as reason:
        if reason:
            return Row(what, 0, skipped=reason)
        packs = Packs(work)
        need = sum(file.stat().st_size for file in packs.path.iterdir()) + 2**16
        faults, examples, refused = {"lost": 0, "leftovers after the next run": 0, "no clear error": 0}, [], 0
        for number in range(count):
            room = need * number // (count - 1)
            status = os.statvfs(work)
            (work / "ballast").write_bytes(bytes(max(0, status.f_bavail * status.f_frsize - room)))
            message = _error_of(lambda: packs.write(1))
            refused += bool(message)
            if message and ("No space left" not in message or str(packs.path) not in message or ".tmp" in message):
                faults["no clear error"] += 1
                examples.append(f"{room} bytes: {message}")
            (work / "ballast").unlink()
            _judge(packs, f"{room} bytes", faults, examples)
        # Refusals that never come, or come always, show nothing.
        faults["none refused, or none done"] = int(not 0 < refused < count)
        return Row(what, count, faults, f"{refused} refused", tuple(examples))


def _read_only_mount(work: Path) -> Row:
    with _tmpfs(work) as reason:
        if reason:
            return Row("read-only disk", 0, skipped=reason)
        packs = Packs(work)
        subprocess.run(["mount", "-o", "remount,ro", str(work)], check=True)
        return _refusal("read-only disk", packs, _error_of(lambda: packs.write(1)))


def _read_only_folder() -> Row:
    """As an ordinary user, who gets through to a folder of its own: root may write anywhere."""
    with tempfile.TemporaryDirectory() as place:
        packs = Packs(Path(place))
        for folder in (Path(place), packs.folder):
            folder.chmod(0o555)
        outcome = in_child(lambda: (os.getuid() or os.setuid(NOBODY), _error_of(lambda: packs.write(1)))[1])
        for folder in (Path(place), packs.folder):
            folder.chmod(0o755)
        return _refusal("read-only folder", packs, str(outcome.answer))


def _refusal(what: str, packs: Packs, message: str) -> Row:
    clear = str(packs.path) in message and "\n" not in message and "cannot write" in message
    faults = {"lost": int(bool(packs.lost())), "leftovers": len(packs.leftovers()), "no clear error": int(not clear)}
    return Row(what, 1, faults, examples=() if clear else (message,))


def _interrupts(work: Path, count: int) -> Row:
    """Ctrl-C at random moments of the command itself."""
    packs, rng = Packs(work), random.Random(0)
    scans = random_character(side=64, expressions=3)
    save_character(scans, work / "scans")
    compress(scans)
    arguments = ["compress", work / "scans", "-o", packs.path, "--overwrite"]
    in_child(lambda: command(arguments, work / "messages"))
    packs.manifests.append((packs.path / MANIFEST).read_bytes())
    typical = in_child(lambda: command(arguments, work / "messages")).seconds
    faults, examples, caught = {"lost": 0, "leftovers": 0, "no clear error": 0}, [], 0
    for number in range(count):
        child = start_child(lambda: os._exit(_interruptible(lambda: command(arguments, work / "messages"))))
        time.sleep(rng.uniform(0.05, 1) * typical)
        os.kill(child, signal.SIGINT)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        messages = (work / "messages").read_text(encoding="utf-8")
        caught += code == 130
        if code == 0:
            # It was done before: faster than was thought, as on a machine that others use.
            typical *= 0.7
        words = [line for line in messages.splitlines() if line and "facezip: warning: " not in line]
        clear = code == 0 or (code == 130 and len(words) == 1 and words[0].startswith("facezip: interrupted"))
        for fault, found in zip(
            faults, (packs.lost(), packs.leftovers(), "" if clear else f"{code} {messages}"), strict=True
        ):
            if found:
                faults[fault] += 1
                examples.append(f"interrupt {number}: {found}")
    # Interrupts that all come too late show nothing.
    faults["none in time"] = int(caught == 0)
    return Row("Ctrl-C", count, faults, f"{caught} in time", tuple(examples))


def _interruptible(work: Callable[[], int]) -> int:
    """Shells start what runs in the background deaf to Ctrl-C, and children inherit that."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    return work()


def _error_of(work: Callable[[], None]) -> str:
    """The message of the one right error, or what came in its place."""
    try:
        work()
    except FaceZipError as error:
        return str(error) if error.code is ErrorCode.CANNOT_WRITE else repr(error)
    except BaseException as error:
        return repr(error)
    return ""


@contextlib.contextmanager
def _tmpfs(folder: Path) -> Iterator[str]:
    """A small disk at ``folder``; yields the reason where there cannot be one."""
    folder.mkdir(parents=True)
    if shutil.which("mount") is None:
        yield "there is no mount command"
        return
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(folder)], capture_output=True, text=True, check=False
    )
    if mounted.returncode:
        yield f"mounting is not permitted ({mounted.stderr.strip()})"
        return
    try:
        yield ""
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)
