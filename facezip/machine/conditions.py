"""Where and with what numbers were measured, and how much memory a process took for them."""

import platform
import resource
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from facezip.machine.cores import cores


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Where numbers were measured.

    Attributes
    ----------
    processor : its name.
    cores : that were used.
    versions : of Python and of libraries, by name.
    """

    processor: str
    cores: int
    versions: Mapping[str, str]


def conditions(libraries: tuple[str, ...]) -> Conditions:
    """The machine and the versions of Python and of ``libraries``, as every measurement states them."""
    versions = {"Python": platform.python_version(), **{name: version(name) for name in libraries}}
    return Conditions(processor=_processor(), cores=cores(), versions=versions)


def peak_memory() -> int:
    """The most bytes that this process has had in memory at one time."""
    # Linux's ru_maxrss begins with the size of the process that started this one; the high-water mark does not.
    status = Path("/proc/self/status")
    lines = status.read_text(encoding="ascii", errors="replace").splitlines() if status.is_file() else []
    marks = [int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:")]
    if marks:
        return marks[0]
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _processor() -> str:
    """The processor's name, as well as the system tells."""
    information = Path("/proc/cpuinfo")
    lines = information.read_text(errors="replace").splitlines() if information.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
