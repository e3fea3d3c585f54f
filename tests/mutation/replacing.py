"""A mutant in the place of a module that others have imported from."""

import inspect
import sys
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

from tests.mutation.operators import Mutant


def file_of(module: str) -> Path:
    """Its source."""
    return Path(*module.split(".")).with_suffix(".py")


def replace(module: ModuleType, mutant: Mutant) -> None:
    """Give the functions of a module, which others hold too, the code of a mutant, and modules its constants."""
    fresh = {"__name__": module.__name__, "__package__": module.__package__, "__file__": module.__file__}
    exec(compile(mutant.tree, str(file_of(module.__name__)), "exec"), fresh)
    mutated = dict(_functions(fresh, module.__name__))
    for name, function in _functions(vars(module), module.__name__):
        function.__code__ = mutated[name].__code__
        function.__defaults__, function.__kwdefaults__ = mutated[name].__defaults__, mutated[name].__kwdefaults__
    for name in mutant.recompiled:
        compiled = vars(module)[name]
        compiled._make_finalizer()()
        compiled._reset_overloads()
    if mutant.of_module:
        for name, value in fresh.items():
            if not name.startswith("__") and not _is_code(value):
                _set_everywhere(name, vars(module)[name], value)


def compile_here(module: ModuleType) -> None:
    """Without numba's cache, which does not see a constant that is another one."""
    for value in vars(module).values():
        if isinstance(value, Dispatcher) and value.__module__ == module.__name__:
            value._cache = NullCache()


def _functions(names: dict[str, Any], module: str) -> Iterator[tuple[str, FunctionType]]:
    """All that a module defines, with the names of their classes."""
    for name, value in names.items():
        if isinstance(value, type) and value.__module__ == module:
            for inner, function in _functions(dict(vars(value)), module):
                yield f"{name}.{inner}", function
        elif (function := _function(value)) is not None and function.__module__ == module:
            yield name, function


def _function(value: Any) -> FunctionType | None:
    match value:
        case property():
            value = value.fget
        case cached_property():
            value = value.func
        case staticmethod() | classmethod():
            value = value.__func__
        case Dispatcher():
            value = value.py_func
    value = inspect.unwrap(value) if callable(value) else value
    return value if isinstance(value, FunctionType) else None


def _is_code(value: Any) -> bool:
    return isinstance(value, type | ModuleType) or _function(value) is not None


def _set_everywhere(name: str, before: Any, after: Any) -> None:
    for module in [*sys.modules.values()]:
        if isinstance(module, ModuleType) and vars(module).get(name) is before:
            setattr(module, name, after)
