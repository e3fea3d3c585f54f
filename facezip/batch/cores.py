"""A process's share of the cores of its machine."""

import os
import sys

import numba
from threadpoolctl import threadpool_limits


def use_cores(count: int) -> None:
    """Let this process work in ``count`` threads, for good. Results do not depend on how many there are."""
    # Every pool of threads here asks for it, and Python 3.13 has PYTHON_CPU_COUNT for the same end.
    os.cpu_count = lambda: count
    numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    threadpool_limits(count)
    if "drjit" in sys.modules:
        sys.modules["drjit"].set_thread_count(count)
