"""What a compiled function depends on besides its own file: functions and constants of other modules are in it."""

import hashlib
import sys
from collections.abc import Callable, Iterator
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

# What compiled code reads of a module as a constant.
CONSTANTS = (bool, int, float, str, tuple, np.generic)


def stamp(function: Callable[..., Any]) -> str:
    """A digest that is another one when any file is that a compiled function takes code from, or a constant of it.

    Numba looks at the function's own file alone: after a change of another one, it would run old code without a word.

    Parameters
    ----------
    function : as Python has it, of a module whose imports are done.
    """
    found: dict[str, ModuleType] = {}
    _follow(function.__module__, found)
    stated = sorted(
        (name, _digest(getattr(module, "__file__", None)), _constants(module)) for name, module in found.items()
    )
    return hashlib.sha256(repr(stated).encode()).hexdigest()


def _follow(name: str, found: dict[str, ModuleType]) -> None:
    """Add a module, and all those whose compiled functions it has, except numba's own."""
    if name in found or name.partition(".")[0] == "numba":
        return
    found[name] = sys.modules[name]
    for function in _compiled(found[name]):
        _follow(function.__module__, found)


def _compiled(module: ModuleType) -> Iterator[Callable[..., Any]]:
    for value in list(vars(module).values()):
        if isinstance(value, Dispatcher):
            yield value.py_func
        elif isinstance(value, _Intrinsic):
            yield value._defn


def _constants(module: ModuleType) -> list[tuple[str, str]]:
    return sorted((name, repr(v)) for name, v in vars(module).items() if name[:2] != "__" and isinstance(v, CONSTANTS))


@cache
def _digest(file: str | None) -> str:
    if file is None:
        return ""
    with open(file, "rb") as source:
        return hashlib.file_digest(source, "sha256").hexdigest()
