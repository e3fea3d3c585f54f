"""A cache that cannot be written is no error, and within a process nothing is compiled twice."""

import errno
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile

from facezip.machine import progress
from facezip.machine.kernels import kernel


def twice(values):
    return 2 * values


def test_a_full_disk_is_no_error_and_nothing_is_compiled_again(monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "save", full)
    compiled = kernel()(twice)
    for _ in range(2):
        np.testing.assert_array_equal(compiled(np.arange(3)), [0, 2, 4])
    assert len(compiled.overloads) == 1
    assert sum(compiled.stats.cache_misses.values()) == 1


@pytest.mark.parametrize("error", [RuntimeError("no locator available")])
def test_without_any_folder_a_kernel_is_compiled_all_the_same(monkeypatch, error):
    def nowhere(*_):
        raise error

    monkeypatch.setattr("facezip.machine.kernels._Cache", nowhere)
    np.testing.assert_array_equal(kernel()(twice)(np.arange(3)), [0, 2, 4])


def test_compiling_is_said_once_and_only_where_bars_are_drawn(monkeypatch):
    said = []
    bars = SimpleNamespace(console=SimpleNamespace(print=said.append))
    monkeypatch.setattr(progress, "_said", set())
    kernel()(twice)(np.arange(3, dtype=np.int8))
    assert said == []
    monkeypatch.setattr(progress, "_shown", [bars])
    monkeypatch.setattr(IndexDataCacheFile, "load", lambda *_: None)
    for dtype in (np.int16, np.int32):
        kernel()(twice)(np.arange(3, dtype=dtype))
    assert said == ["Preparing kernels (once)"]
