"""Before a test imports Dr.Jit, whoever does: the library that it compiles with is chosen while it is loaded."""

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from types import ModuleType


class BeforeDrJit(MetaPathFinder):
    """Finds nothing itself; where Dr.Jit is about to be found, names it an LLVM that does not abort.

    It stays among the finders: Python is going through them when it is called, and would skip the next.
    """

    done = False

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        """Called for every import that is the first of its module."""
        if name == "drjit" and not self.done:
            self.done = True
            from render.llvm import prefer_usable

            prefer_usable()


def choose_llvm_in_time() -> None:
    """Once, and at no cost for tests that never import Dr.Jit."""
    if not any(isinstance(finder, BeforeDrJit) for finder in sys.meta_path):
        sys.meta_path.insert(0, BeforeDrJit())
