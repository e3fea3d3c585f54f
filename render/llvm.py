"""Start Mitsuba on a usable LLVM, or say in one line why not.

Dr.Jit takes the first libLLVM that it finds. It refuses version 14, and accepts 15 and 16 only to abort the whole
process in its first kernel ("Cannot select: fminimum"). So the library is chosen and its version asked for here, in
a child process, before Dr.Jit is imported.
"""

import logging
import os
import subprocess
import sys
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.cores import cores
from render.documents.conditions import Versions

_log = logging.getLogger("facezip")

VARIABLE = "DRJIT_LIBLLVM_PATH"
VARIANT = "llvm_ad_rgb"
OLDEST = 17
CARRIER = "karellen-llvm-core"

_SYSTEM = (
    "usr/lib/libLLVM*.so*",
    "usr/lib/*-linux-gnu/libLLVM*.so*",
    "usr/lib64/libLLVM*.so*",
    "usr/lib/llvm-*/lib/libLLVM.*",
    "opt/homebrew/opt/llvm/lib/libLLVM.dylib",
)

# LLVMGetVersion exists since LLVM 16; whatever lacks it is too old.
_ASK = """
import ctypes, sys
library, version = ctypes.CDLL(sys.argv[1]), [ctypes.c_uint() for _ in range(3)]
library.LLVMGetVersion(*map(ctypes.byref, version))
print(version[0].value)
"""


@cache
def start() -> Versions:
    """Choose an LLVM, set Mitsuba's variant, and return the versions that belong to every rendered number.

    A path in ``DRJIT_LIBLLVM_PATH`` comes first and must be usable; otherwise the library that the package
    ``karellen-llvm-core`` carries, otherwise the system's.

    Raises
    ------
    FaceZipError
        ``NO_LLVM``: no library of version 17 or newer.
    """
    os.environ[VARIABLE] = str(usable_library(os.environ.get(VARIABLE)))
    import drjit
    import mitsuba

    check_loaded()
    drjit.set_thread_count(cores())
    mitsuba.set_variant(VARIANT)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return Versions(
        variant=VARIANT,
        mitsuba=mitsuba.__version__,
        drjit=drjit.__version__,
        llvm=".".join(map(str, drjit.detail.llvm_version())),
    )


def check_loaded() -> None:
    """Raise ``FaceZipError`` (``NO_LLVM``) where Dr.Jit was imported earlier, with a library that would abort."""
    import drjit

    version = drjit.detail.llvm_version()[0]
    if version < OLDEST:
        # -1 where it found none that it takes.
        reason = f"Dr.Jit was imported earlier and holds {f'LLVM {version}' if version > 0 else 'no LLVM'}"
        remedy = f"import facezip's renderer before drjit and mitsuba, or set {VARIABLE} to LLVM {OLDEST} or newer"
        raise FaceZipError(ErrorCode.NO_LLVM, f"{reason}; {remedy}")


def prefer_usable() -> None:
    """Name Dr.Jit a library that does not abort, before others import it; where there is none, change nothing."""
    asked = os.environ.get(VARIABLE)
    for wish in dict.fromkeys((asked, None)):
        with suppress(FaceZipError):
            os.environ[VARIABLE] = str(usable_library(wish))
            break
    if asked and asked != os.environ[VARIABLE]:
        _log.warning("%s: no LLVM %d or newer; %s serves instead", asked, OLDEST, os.environ[VARIABLE])


def usable_library(asked: str | None) -> Path:
    """The libLLVM to render with: the one at a path that was asked for, or the best there is.

    Raises
    ------
    FaceZipError
        ``NO_LLVM``, naming what was found and what to do.
    """
    seen = []
    for path in [Path(asked)] if asked else [*_carried(), *_system()]:
        version = _version(path)
        if version is not None and version >= OLDEST:
            return path
        seen.append(f"{path} ({'older than 16 or no LLVM' if version is None else f'LLVM {version}'})")
    remedy = f"unset {VARIABLE} or point it at one" if asked else f"'pip install {CARRIER}' or set {VARIABLE} to one"
    raise FaceZipError(
        ErrorCode.NO_LLVM, f"no LLVM {OLDEST} or newer to render with; found {', '.join(seen) or 'none'}; {remedy}"
    )


def _carried() -> list[Path]:
    try:
        listed = files(CARRIER) or []
    except PackageNotFoundError:
        return []
    paths = {Path(str(file.locate())).resolve() for file in listed if "libLLVM" in file.name}
    return sorted(path for path in paths if path.is_file())


def _system() -> list[Path]:
    found = [path for pattern in _SYSTEM for path in Path("/").glob(pattern)]
    return list({path.resolve(): None for path in sorted(found, reverse=True)})


@cache
def _version(library: Path) -> int | None:
    """The major version that a library states, asked in a child process: a wrong library may crash its host."""
    command = [sys.executable, "-c", _ASK, str(library)]
    try:
        asked = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except subprocess.TimeoutExpired:
        return None
    return int(asked.stdout) if asked.returncode == 0 and asked.stdout.strip().isdigit() else None
