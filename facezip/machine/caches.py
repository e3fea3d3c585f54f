"""Places for the caches of libraries where their own cannot be written to: a container, a read-only home.

Numba keeps compiled kernels beside their sources or in the home folder, and raises where it can do neither; Dr.Jit and
matplotlib complain, and begin anew each time. What they keep is run later, so the folder that stands in is ours alone.
"""

import os
import stat
import sys
from glob import escape, glob
from pathlib import Path

# Writable in most containers whose disks are not: it is memory.
_MEMORY = "/dev/shm"
_CACHES = {"darwin": "Library/Caches", "win32": "AppData/Local"}.get(sys.platform, ".cache")


def settle() -> None:
    """Name a folder that can be written to for each library that has none; processes started later take it too.

    Variables that name such a folder stay as they are, and nothing is created where all is well.
    """
    home = _home()
    caches = _caches(home)
    settings = os.environ.get("XDG_CONFIG_HOME") or f"{home}/.config"
    # Numba has a folder of each folder of sources, which others may have made: with sudo, say.
    usual = {
        "NUMBA_CACHE_DIR": [f"{caches}/numba", *glob(f"{escape(caches)}/numba/*/")],
        "DRJIT_CACHE_DIR": [f"{home}/.drjit"],
        "MPLCONFIGDIR": [f"{settings}/matplotlib", f"{caches}/matplotlib"],
    }
    named = {variable: [os.environ[variable]] for variable in usual if os.environ.get(variable)}
    lost = [variable for variable, folders in {**usual, **named}.items() if not all(map(_writable, folders))]
    stand_in = private_folder() if lost else None
    if stand_in:
        os.environ.update({variable: str(stand_in / variable.partition("_")[0].lower()) for variable in lost})


def kept_folder(name: str) -> Path | None:
    """A folder of FaceZip's own in which files stay from run to run; None where there is no place for it."""
    kept = Path(_caches(_home())) / "facezip" / name
    if _writable(str(kept)):
        return kept
    stand_in = private_folder()
    return stand_in / name if stand_in else None


def _home() -> str:
    # Without a home its sign is expanded to itself; nothing is below a device.
    return os.path.expanduser("~") if os.path.isabs(os.path.expanduser("~")) else os.devnull


def _caches(home: str) -> str:
    return os.environ.get("XDG_CACHE_HOME") or f"{home}/{_CACHES}"


def private_folder() -> Path | None:
    """A folder among the temporary ones that nobody else has written to, or can; None where there is no place for it.

    It is there for later processes too, unless somebody else has taken its name: then it lasts as long as this one.
    """
    for parent in _temporary():
        folder = parent / f"facezip-{os.getuid() if hasattr(os, 'getuid') else 'caches'}"
        try:
            folder.mkdir(0o700, exist_ok=True)
            return folder if _is_private(folder) else _passing(parent)
        except OSError:
            continue
    return None


def _temporary() -> list[Path]:
    from tempfile import gettempdir

    memory = [Path(_MEMORY)] if os.path.isdir(_MEMORY) else []
    try:
        return [Path(gettempdir()), *memory]
    except OSError:
        return memory


def _is_private(folder: Path) -> bool:
    found = folder.lstat()
    mine = not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o077)
    return stat.S_ISDIR(found.st_mode) and mine and os.access(folder, os.W_OK | os.X_OK)


def _passing(parent: Path) -> Path:
    import atexit
    from shutil import rmtree
    from tempfile import mkdtemp

    folder = Path(mkdtemp(prefix="facezip-", dir=parent))
    atexit.register(rmtree, folder, ignore_errors=True)
    return folder


def _writable(folder: str) -> bool:
    """Whether files can be made in a folder, or it could be made."""
    place = os.path.abspath(folder)
    while not os.path.lexists(place):
        place = os.path.dirname(place)
    return os.path.isdir(place) and os.access(place, os.W_OK | os.X_OK)
