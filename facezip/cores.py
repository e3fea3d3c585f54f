"""How many cores this process works on; the results of nothing here depend on it."""

import os
import sys

_share: int | None = None


def cores() -> int:
    """The threads that work side by side: one a core of the machine, or as many as :func:`use_cores` said."""
    return _share or os.cpu_count() or 1


def use_cores(count: int) -> None:
    """Let this process work on ``count`` cores from now on, those of its libraries too."""
    import numba
    from threadpoolctl import threadpool_limits

    global _share
    _share = count
    numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    threadpool_limits(count)
    if "drjit" in sys.modules:
        sys.modules["drjit"].set_thread_count(count)
