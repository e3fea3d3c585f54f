"""The one error type of FaceZip, and the exit codes of its command line."""

from collections.abc import Callable
from enum import IntEnum, StrEnum

from facezip.names import printable


class ExitCode(IntEnum):
    """What a finished ``facezip`` command tells the shell."""

    DONE = 0
    USAGE = 2
    BAD_INPUT = 3
    CANNOT_WRITE = 4
    DIFFERENCE = 7

    @property
    def meaning(self) -> str:
        """One phrase for the help text."""
        return {
            ExitCode.DONE: "done",
            ExitCode.USAGE: "wrong usage",
            ExitCode.BAD_INPUT: "bad input",
            ExitCode.CANNOT_WRITE: "could not write",
            ExitCode.DIFFERENCE: "difference found, or something to decide",
        }[self]


class ErrorCode(StrEnum):
    """Every way in which FaceZip refuses its input or its surroundings."""

    MISSING_FILE = "missing-file"
    CANNOT_READ = "cannot-read"
    TOO_LARGE = "too-large"
    UNSAFE_NAME = "unsafe-name"
    UNREADABLE_IMAGE = "unreadable-image"
    UNREADABLE_MESH = "unreadable-mesh"
    BAD_TEXELS = "bad-texels"
    SIZE_MISMATCH = "size-mismatch"
    TOPOLOGY_MISMATCH = "topology-mismatch"
    OTHER_NEUTRAL = "other-neutral"
    TOO_FEW_EXPRESSIONS = "too-few-expressions"
    TOO_MANY_MASKS = "too-many-masks"
    BAD_CHARACTER = "bad-character"
    BAD_PACK = "bad-pack"
    DAMAGED_PACK = "damaged-pack"
    OTHER_FORMAT = "other-format"
    UNKNOWN_NAME = "unknown-name"
    BAD_VALUE = "bad-value"
    OUT_OF_REACH = "out-of-reach"
    NOTHING_TO_SEE = "nothing-to-see"
    NO_LLVM = "no-llvm"
    NO_GPU = "no-gpu"
    NO_SCHEDULER = "no-scheduler"
    WORKER_LOST = "worker-lost"
    CANNOT_WRITE = "cannot-write"


class FaceZipError(Exception):
    """Bad input or surroundings, said in one line: what is wrong, where, and what to do.

    Parameters
    ----------
    code : which case it is; stable, for programs.
    message : one line for people; names the file, the reason and the remedy. Names in it may be hostile: what a
        terminal would obey is escaped.

    """

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(printable(message))
        self.code = code

    def __reduce__(self) -> tuple[type["FaceZipError"], tuple[ErrorCode, str]]:
        # Workers send it to the process that asked.
        return type(self), (self.code, str(self))

    @property
    def exit_code(self) -> ExitCode:
        """The process exit code that the command line answers with."""
        return ExitCode.CANNOT_WRITE if self.code is ErrorCode.CANNOT_WRITE else ExitCode.BAD_INPUT


# What becomes of an error: it is raised, or kept beside others where all are asked for.
Refuse = Callable[[FaceZipError], None]


def raised(error: FaceZipError) -> None:
    """Raise an error: the first one ends the work."""
    raise error
