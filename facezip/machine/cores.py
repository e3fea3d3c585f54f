"""How many cores this process works on; the results of nothing here depend on it."""

import os

_share: int | None = None


def cores() -> int:
    """The threads that work side by side: one a core that it may use, or as many as :func:`use_cores` said."""
    if _share:
        return _share
    # A container or a scheduler of jobs may leave it fewer than the machine has; not every system can tell.
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def use_cores(count: int) -> None:
    """Let this process work on ``count`` cores from now on; the renderer asks when it starts."""
    import numba
    from threadpoolctl import threadpool_limits

    global _share
    _share = count
    numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    threadpool_limits(count)
