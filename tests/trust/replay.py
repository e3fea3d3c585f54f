"""System calls that changed a folder, done again to a disk in memory."""

from collections.abc import Iterable
from pathlib import Path

from tests.trust.disks import Disk, Node
from tests.trust.system_calls import Call, string


def replay(calls: Iterable[Call], folder: Path, disk: Disk) -> None:
    """Do to a disk what calls did below a folder; LookupError for one that changes it in a way that is not known."""
    again = _Replay(folder, disk)
    for call in calls:
        if call.result >= 0:
            again.call(call)


class _Replay:
    """The offsets of descriptors beside the disk."""

    def __init__(self, folder: Path, disk: Disk) -> None:
        self._folder, self._disk = folder, disk
        self._offsets: dict[int, int] = {}
        self._known = {
            **dict.fromkeys(("open", "openat", "creat"), self._open),
            **dict.fromkeys(("write", "pwrite64"), self._write),
            **dict.fromkeys(("fsync", "fdatasync"), self._sync),
            **dict.fromkeys(("rename", "renameat", "renameat2"), self._rename),
            **dict.fromkeys(("unlink", "unlinkat", "rmdir"), self._remove),
            **dict.fromkeys(("mkdir", "mkdirat"), self._make_folder),
            "ftruncate": self._truncate,
            "lseek": self._seek,
        }

    def call(self, call: Call) -> None:
        if call.name in self._known:
            self._known[call.name](call)
        elif any(self._below(call, place) for place in range(len(call.arguments))):
            raise LookupError(f"{call.name} is not replayed")

    def _below(self, call: Call, place: int) -> Path | None:
        path = call.path(place)
        return path.relative_to(self._folder) if path is not None and path.is_relative_to(self._folder) else None

    def _open(self, call: Call) -> None:
        place = int(call.name == "openat")
        path, flags = self._below(call, place), call.arguments[place + 1]
        self._offsets[call.result] = 0
        if path is None:
            return
        if "O_CREAT" in flags and self._disk.find(path) is None:
            self._disk.rename((path, Node()))
        elif "O_TRUNC" in flags:
            self._disk.write(self._disk.node(path), b"")
        if "O_APPEND" in flags:
            raise LookupError("O_APPEND is not replayed")

    def _write(self, call: Call) -> None:
        path = self._below(call, 0)
        if path is None:
            return
        node, data = self._disk.node(path), string(call.arguments[1])[: call.result]
        start = int(call.arguments[3]) if call.name == "pwrite64" else self._offsets[call.descriptor]
        if call.name == "write":
            self._offsets[call.descriptor] += call.result
        content = node.content.ljust(start, b"\0")
        self._disk.write(node, content[:start] + data + content[start + len(data) :])

    def _truncate(self, call: Call) -> None:
        path, length = self._below(call, 0), int(call.arguments[1])
        if path is not None:
            node = self._disk.node(path)
            self._disk.write(node, node.content[:length].ljust(length, b"\0"))

    def _seek(self, call: Call) -> None:
        self._offsets[call.descriptor] = call.result

    def _sync(self, call: Call) -> None:
        path = self._below(call, 0)
        if path is not None:
            self._disk.sync(self._disk.node(path))

    def _rename(self, call: Call) -> None:
        at = call.name != "rename"
        old, new = self._below(call, int(at)), self._below(call, 3 if at else 1)
        if old is None or new is None:
            return
        exchanged = "RENAME_EXCHANGE" in call.arguments[-1]
        self._disk.rename((new, self._disk.node(old)), (old, self._disk.node(new) if exchanged else None))

    def _remove(self, call: Call) -> None:
        path = self._below(call, int(call.name == "unlinkat"))
        if path is not None:
            self._disk.rename((path, None))

    def _make_folder(self, call: Call) -> None:
        path = self._below(call, int(call.name == "mkdirat"))
        if path is not None:
            self._disk.rename((path, Node(entries={})))
