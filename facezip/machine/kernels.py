"""How functions are compiled, and where they are kept: numba's machine code, beside the sources or where it may be."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

from facezip.machine.kernel_sources import stamp
from facezip.machine.progress import say_once

# Numba's decorators carry no types, and take arrays of several.
Compiled = Callable[[Callable[..., Any]], Any]


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's, for whom what is kept is old once any file is another that it came from, not the function's own alone.

    A disk that is full is no reason to give up: what is compiled serves the process.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = IndexDataCacheFile(self._cache_path, self._impl.filename_base, stamp(function))

    def load_overload(self, sig: object, target_context: object) -> object:
        found = super().load_overload(sig, target_context)
        if found is None:
            say_once("Preparing kernels (once)")
        return found

    def save_overload(self, sig: object, data: object) -> None:
        with suppress(OSError):
            super().save_overload(sig, data)


def kernel(**options: Any) -> Compiled:
    """For a function that Python calls: compiled without the interpreter lock, and kept for later processes.

    Parameters
    ----------
    options : numba's, as ``fastmath={"contract"}``.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = njit(nogil=True, **options)(function)
        # Numba raises where it finds no folder at all: then every process compiles for itself.
        with suppress(RuntimeError):
            dispatcher._cache = _Cache(function)
        return dispatcher

    return compiled


def inner(**options: Any) -> Compiled:
    """For a function that only compiled code calls: it becomes a part of what calls it, and compiles in less time.

    Parameters
    ----------
    options : as of :func:`kernel`.
    """
    compiled: Compiled = njit(nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)
    return compiled
