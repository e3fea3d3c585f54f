"""The finder that chooses an LLVM lets the others be asked as without it."""

import sys
from importlib.abc import MetaPathFinder
from importlib.util import find_spec

import pytest

import render.llvm
from render.plugin.imports import BeforeDrJit, choose_llvm_in_time


class Asked(MetaPathFinder):
    """Remembers what it is asked for, and finds nothing."""

    def __init__(self):
        self.names = []

    def find_spec(self, name, path, target=None):
        self.names.append(name)


@pytest.fixture
def finders(monkeypatch):
    """The second finder, where ours is the first; and how often an LLVM was chosen."""
    chosen, second = [], Asked()
    others = [finder for finder in sys.meta_path if not isinstance(finder, BeforeDrJit)]
    monkeypatch.setattr(sys, "meta_path", [second, *others])
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    monkeypatch.setattr(render.llvm, "prefer_usable", lambda: chosen.append("an LLVM"))
    choose_llvm_in_time()
    return second, chosen


def test_every_other_finder_is_asked_for_dr_jit_and_an_llvm_is_chosen_once(finders):
    second, chosen = finders
    for _ in range(2):
        find_spec("drjit")
    choose_llvm_in_time()
    assert second.names == ["drjit", "drjit"]
    assert chosen == ["an LLVM"]
