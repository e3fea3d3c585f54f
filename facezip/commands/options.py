"""Options that several verbs share, and the two ways in which a verb answers."""

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from facezip.documents.document import Data, Document, to_json
from facezip.names import printable


class _Place(click.Path):
    """A path that says something: an empty one would be the current folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path; a wrong call that names the option or argument where nothing is named."""
        if value == "":
            self.fail("the path is empty; name a file or folder, or . for the current one.", param, ctx)
        return super().convert(value, param, ctx)


FOLDER = _Place(path_type=Path)


class FiniteRange(click.FloatRange):
    """Numbers of a range: ``nan``, which no comparison refuses, and ``inf`` are none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; a wrong call that names the option where it is none."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{number} is no number that can be used here.", param, ctx)
        return number


as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON document on stdout, and nothing else.")
# Of the embedded character, and of what is measured.
seed = click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, show_default=True, metavar="S")
expressions = click.option("--expressions", type=click.IntRange(min=2), default=20, show_default=True, metavar="N")
resolution = click.option(
    "--resolution", type=click.IntRange(64, 4096), default=512, show_default=True, metavar="TEXELS"
)
scans = click.option("--character", type=FOLDER, metavar="FOLDER", help="Scans.  [default: the embedded character]")
repeats = click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, metavar="N")
overwrite = click.option("--overwrite", is_flag=True, help="Replace an output that facezip made before.")


def on_line(context: click.Context) -> set[str]:
    """Names of the options that stand on the command line."""
    return {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}


def check_embedded(character: Path | None, *names: str) -> None:
    """Refuse options of the embedded character beside scans, to which they would say nothing."""
    if character is None or not on_line(click.get_current_context()) & {*names}:
        return
    *others, last = (f"--{name}" for name in names)
    words = f"{', '.join(others)} and {last} are" if others else f"{last} is"
    left = "those" if others else "it"
    raise click.UsageError(f"{words} of the embedded character: leave {left} out")


def _bytes(context: click.Context, option: click.Parameter, value: str | None) -> int | None:
    """A size such as 2G or 800M, in powers of ten."""
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)([MGT])B?", value.upper()) if value else None
    if value and not found:
        raise click.BadParameter(f"'{value}' is no size; say it in megabytes or gigabytes, as 800M or 2G")
    return round(float(found[1]) * {"M": 1e6, "G": 1e9, "T": 1e12}[found[2]]) if found else None


def _memory(taken: str) -> Callable[..., Any]:
    text = f"The most memory that {taken}, such as 2G. The rest waits on the disk.  [default: no limit]"
    return click.option("--memory", callback=_bytes, metavar="SIZE", help=text)


memory, memory_of_each = _memory("is used"), _memory("each process uses")


def worker_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Who works: ``--workers`` on this machine, or those of a ``--scheduler``."""

    def either(context: click.Context, option: click.Parameter, value: Any) -> Any:
        other = "workers" if option.name == "scheduler" else "scheduler"
        if value is not None and context.params.get(other) is not None:
            raise click.UsageError("--workers are of this machine, those of a --scheduler are not: give one of the two")
        return value

    help_workers, help_scheduler = (
        "How many processes on this machine.",
        "Let a dask cluster do the work: tcp://host:8786.",
    )
    command = click.option("--scheduler", metavar="ADDRESS", callback=either, help=help_scheduler)(command)
    count = click.IntRange(min=1)
    return click.option("--workers", type=count, metavar="N", callback=either, help=help_workers)(command)


def answer(document: Document | Data, as_json: bool, lines: Callable[[], Sequence[str]]) -> None:
    """Print the document as JSON, or the lines that say the same to a person."""
    # click.echo takes ASCII for a mistake and writes UTF-8.
    print(to_json(document) if as_json else "\n".join(map(printable, lines())))
