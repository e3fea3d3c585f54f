"""What benchmarks answer, number by number: ``benchmarks/answers.csv``.

A figure is called by the name of its question and the path to it in the answer, lists by their entries' own names:
``maps/ways/shared/errors/albedo/rmse``. Times are of a machine, and are left out.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from facezip.character.loading import save_character
from facezip.machine.progress import track
from reports.kept.inputs import ANYTHING, digest
from reports.kept.measure import EXPRESSIONS, answer
from reports.kept.table import read_table, write_table
from scenes.character import make_character

# What is no figure, or one of a machine; numbers of single expressions or shapes, "rmse_per_shape", are left out too.
LEFT_OUT = ("format", "conditions", "seconds", "size")
DECIMALS = 4


@dataclass(frozen=True)
class Figure:
    """A row: the question and the path of a number in its answer, the number, and what both are of."""

    key: str
    value: float
    inputs: str
    command: str


@dataclass(frozen=True)
class Question:
    """A command whose answer is kept.

    Attributes
    ----------
    name : with which its figures' keys begin.
    command : as a user types it after ``facezip``.
    ask : what gives the answer; None where the command alone does.
    scans : a folder that it is asked of.
    """

    name: str
    command: str
    ask: Callable[[], dict[str, Any]] | None = None
    scans: Path | None = None

    @cached_property
    def inputs(self) -> str:
        """Digest of what its figures depend on."""
        return digest(ANYTHING, self.scans, self.command)

    def figures(self) -> Iterator[Figure]:
        """Ask, and give every number of the answer."""
        found = self.ask() if self.ask else answer(*self.command.split())
        for path, value in numbers(found):
            yield Figure(f"{self.name}/{path}", value, self.inputs, self.command)


def questions(captures: Sequence[Path]) -> list[Question]:
    """All that is asked; ``captures`` are folders of scans."""
    of_captures = [Question(f"blocks-{one.name}", EXPORT, partial(_exported, one), one) for one in captures]
    return [*QUESTIONS, *of_captures]


def _exported(folder: Path | None = None) -> dict[str, Any]:
    """What blocks and mip-maps do to the pack of a capture, or of the embedded head."""
    with TemporaryDirectory(prefix="facezip-kept-") as place:
        scans, pack = folder or Path(place) / "scans", Path(place) / "me.facezip"
        if not folder:
            save_character(make_character(512, EXPRESSIONS), scans)
        answer("compress", scans, "-o", pack)
        found = answer("export", pack, "--to", "godot", "--textures", "dds", "-o", Path(place) / "out")
    return {part: found[part] for part in ("codec", "mips")}


def _cleaned() -> dict[str, Any]:
    """By step and error, the least and the most over persons."""
    people = list(answer(*CLEAN.split())["people"].values())

    def over(step: str, error: str) -> dict[str, float]:
        values = [person[step][error] for person in people]
        return {"least": min(values), "most": max(values)}

    return {step: {error: over(step, error) for error in errors} for step, errors in people[0].items()}


EXPORT, CLEAN = "export me.facezip --to godot --textures dds -o out", "bench clean --seed 1 --seeds 4"
QUESTIONS = (
    Question("maps", "bench maps"),
    Question("maps-clean", "bench maps --nuisances 0"),
    Question("rig", "bench rig"),
    Question("clean", CLEAN, _cleaned),
    Question("blocks", EXPORT, _exported),
)


def numbers(document: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a document, by its path."""
    if isinstance(document, Mapping):
        for name, value in document.items():
            if name not in LEFT_OUT and "_per_" not in name:
                yield from numbers(value, f"{path}/{name}" if path else str(name))
    elif isinstance(document, list):
        for place, value in enumerate(document):
            yield from numbers(value, f"{path}/{_name_of(value, place)}")
    elif isinstance(document, int | float) and not isinstance(document, bool):
        yield path, round(float(document), DECIMALS)


def _name_of(entry: Any, place: int) -> str:
    """What a path calls an entry of a list: its name, the side of a mip-map, or its place."""
    known = entry if isinstance(entry, Mapping) else {}
    if "size" in known:
        return str(known["size"][0])
    return str(known.get("way", place))


def unanswered(asked: Sequence[Question], figures: Mapping[str, Figure]) -> list[Question]:
    """The questions whose figures are missing or of other inputs."""
    known = {(figure.key.partition("/")[0], figure.inputs) for figure in figures.values()}
    return [question for question in asked if (question.name, question.inputs) not in known]


def ask(questions: Sequence[Question]) -> Iterator[tuple[Question, list[Figure]]]:
    """Every question with the figures of its answer, as soon as it is there."""
    for question in track(questions, "Asking", len(questions)):
        yield question, list(question.figures())


def read_figures(path: Path) -> dict[str, Figure]:
    """The figures of a file by their keys; none where there is no file yet."""
    return {figure.key: figure for figure in read_table(path, Figure)}


def write_figures(path: Path, figures: Sequence[Figure]) -> None:
    """Write figures in the order of their keys; raises ``CANNOT_WRITE``."""
    write_table(path, Figure, map(_cells, sorted(figures, key=lambda one: one.key)))


def _cells(figure: Figure) -> dict[str, object]:
    # A count is no fraction.
    return asdict(figure) | ({"value": int(figure.value)} if figure.value.is_integer() else {})
