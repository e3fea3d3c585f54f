"""A disk in memory that can lose power: what was asked of it, and every state in which that may leave it.

What may be lost is what journalling file systems may lose. Names change in the order in which they were changed, or
those of one folder without those of the others; a folder that was synced has all of its changes so far. Of a file's
bytes that were not synced there may be all, none, a part, or zeros in their place.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

# Bytes by path; None for folders.
State = dict[str, bytes | None]
# What may become of a file whose first bytes are synced, and whose second ones were written.
FATES: dict[str, Callable[[bytes, bytes], bytes]] = {
    "all": lambda synced, written: written,
    "none": lambda synced, written: synced,
    "torn": lambda synced, written: written[: (len(synced) + len(written)) // 2],
    "zeros": lambda synced, written: synced + bytes(max(0, len(written) - len(synced))),
}


@dataclass(eq=False)
class Node:
    """A file as programs see it, or a folder where ``entries`` is not None; ``first`` is on the disk from the start."""

    content: bytes = b""
    entries: "dict[str, Node] | None" = None
    first: bytes = b""


@dataclass(frozen=True, eq=False)
class Write:
    """A file's content becomes another one."""

    node: Node
    content: bytes


@dataclass(frozen=True, eq=False)
class Sync:
    """What was done to a file or folder is on the disk."""

    node: Node


@dataclass(frozen=True, eq=False)
class Names:
    """Names in folders come to stand for something else, or for nothing, all at one stroke."""

    changes: tuple[tuple[Node, str, Node | None], ...]

    @property
    def folders(self) -> set[Node]:
        return {folder for folder, _, _ in self.changes}


class Disk:
    """A tree as programs see it, what it was at first, and the steps between."""

    def __init__(self, folder: Path) -> None:
        self.steps: list[Write | Sync | Names] = []
        self.first: dict[Node, dict[str, Node]] = {}
        self.root = self._copied(folder)

    def _copied(self, path: Path) -> Node:
        if not path.is_dir():
            content = path.read_bytes()
            return Node(content, first=content)
        node = Node(entries={entry.name: self._copied(entry) for entry in path.iterdir()})
        self.first[node] = dict(node.entries or {})
        return node

    def find(self, path: Path) -> Node | None:
        """What a path below the root stands for."""
        node: Node | None = self.root
        for part in path.parts:
            node = None if node is None or node.entries is None else node.entries.get(part)
        return node

    def node(self, path: Path) -> Node:
        """As :meth:`find`, where it must be something."""
        found = self.find(path)
        if found is None:
            raise LookupError(f"nothing is known of {path}")
        return found

    def write(self, node: Node, content: bytes) -> None:
        node.content = content
        self.steps.append(Write(node, content))

    def sync(self, node: Node) -> None:
        self.steps.append(Sync(node))

    def rename(self, *pairs: tuple[Path, Node | None]) -> None:
        """Let paths stand for nodes, or for nothing."""
        changes = tuple((self.node(path.parent), path.name, node) for path, node in pairs)
        _apply(changes, {folder: folder.entries for folder, _, _ in changes if folder.entries is not None})
        self.steps.append(Names(changes))


def states(disk: Disk) -> Iterator[tuple[int, str, State]]:
    """Every state, once, that a cut of power may leave: after how many steps it came, what was lost, and the tree."""
    seen: set[int] = set()
    for cut in range(len(disk.steps), -1, -1):
        for names, kept in _kept(disk.steps[:cut]):
            for fate in FATES:
                state = _left(disk, cut, kept, fate)
                key = hash(frozenset(state.items()))
                if key not in seen:
                    seen.add(key)
                    yield cut, f"cut after step {cut} of {len(disk.steps)}, {names}, unsynced bytes: {fate}", state


def _kept(steps: Sequence[Write | Sync | Names]) -> Iterator[tuple[str, set[int]]]:
    """Which changes of names are on the disk: those that are synced, and a run of the others, or one folder's."""
    changes = {number: step for number, step in enumerate(steps) if isinstance(step, Names)}
    synced = {step.node: number for number, step in enumerate(steps) if isinstance(step, Sync)}
    certain = {n for n, step in changes.items() if any(synced.get(folder, -1) > n for folder in step.folders)}
    for end in [*changes, len(steps)]:
        yield f"names as of step {end}", certain | {n for n in changes if n < end}
    for folder in dict.fromkeys(folder for step in changes.values() for folder in step.folders):
        yield "names of one folder", certain | {n for n, step in changes.items() if step.folders == {folder}}


def _left(disk: Disk, cut: int, kept: set[int], fate: str) -> State:
    entries = {folder: dict(names) for folder, names in disk.first.items()}
    written: dict[Node, bytes] = {}
    synced: dict[Node, bytes] = {}
    for number, step in enumerate(disk.steps[:cut]):
        if isinstance(step, Write):
            written[step.node] = step.content
        elif isinstance(step, Sync):
            synced[step.node] = written.get(step.node, step.node.first)
        elif number in kept:
            _apply(step.changes, entries)
    left: State = {}

    def walk(folder: Node, path: str) -> None:
        for name, node in entries.get(folder, {}).items():
            if node.entries is None:
                on_disk = synced.get(node, node.first)
                left[path + name] = FATES[fate](on_disk, written.get(node, on_disk))
            else:
                left[path + name] = None
                walk(node, f"{path}{name}/")

    walk(disk.root, "")
    return left


def _apply(changes: tuple[tuple[Node, str, Node | None], ...], entries: dict[Node, dict[str, Node]]) -> None:
    for folder, name, node in changes:
        names = entries.setdefault(folder, {})
        names.pop(name, None)
        if node is not None:
            names[name] = node


def lay_out(state: State, folder: Path) -> None:
    """Make a tree on a real disk."""
    folder.mkdir(parents=True)
    for path, content in state.items():
        if content is None:
            (folder / path).mkdir()
        else:
            (folder / path).write_bytes(content)
