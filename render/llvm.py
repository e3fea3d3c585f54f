"""Start Mitsuba on a usable LLVM, or say in one line why not.

Dr.Jit takes the first libLLVM that it finds. It refuses version 14, and accepts 15 and 16 only to abort the whole
process in its first kernel ("Cannot select: fminimum"). So the library is chosen and its version asked for here, in
a child process, before Dr.Jit is imported.
"""

import os
import subprocess
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.cores import cores

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
def start() -> dict[str, str]:
    """Choose an LLVM, set Mitsuba's variant, and return the versions that belong to every rendered number.

    A path in ``DRJIT_LIBLLVM_PATH`` comes first and must be usable; otherwise the library that the package
    ``karellen-llvm-core`` carries, otherwise the system's.

    Raises
    ------
    FaceZipError
        ``NO_LLVM``: no library of version 17 or newer.
    """
    library = usable_library()
    os.environ[VARIABLE] = str(library)
    import drjit
    import mitsuba

    version = drjit.detail.llvm_version()
    if version[0] < OLDEST:
        raise FaceZipError(
            ErrorCode.NO_LLVM,
            f"Dr.Jit was imported earlier and holds LLVM {version[0]}; start the renderer before drjit and mitsuba",
        )
    drjit.set_thread_count(cores())
    mitsuba.set_variant(VARIANT)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return {
        "variant": VARIANT,
        "mitsuba": mitsuba.__version__,
        "drjit": drjit.__version__,
        "llvm": ".".join(map(str, version)),
    }


def usable_library() -> Path:
    """The libLLVM to render with.

    Raises
    ------
    FaceZipError
        ``NO_LLVM``, naming what was found and what to do.
    """
    asked = os.environ.get(VARIABLE)
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
