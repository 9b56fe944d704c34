"""Threads for the compiled kernels, which release the GIL."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

_MIN_CHUNK = 512
"""Fewest problems that are worth a thread of their own."""


def in_threads(run: Callable[[slice], None], n_problems: int) -> None:
    """Call a function that releases the GIL on consecutive parts of a batch, one per processor.

    Parameters
    ----------
    run : callable
        Takes a slice of the batch. What it writes must not depend on how the batch is cut.
    n_problems : int
    """
    n_parts = n_problems // _MIN_CHUNK
    if n_parts > 1:
        n_parts = min(n_parts, _n_processors())
    if n_parts <= 1:
        return run(slice(0, n_problems))
    bounds = [n_problems * i // n_parts for i in range(n_parts + 1)]
    parts = [slice(start, stop) for start, stop in zip(bounds[:-1], bounds[1:], strict=True)]
    others = [_pool(os.getpid()).submit(run, part) for part in parts[1:]]
    run(parts[0])
    for other in others:
        other.result()


def _n_processors() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """Keep threads, which take as long to start as a small batch; they do not survive a fork."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="geomstats_anim")
