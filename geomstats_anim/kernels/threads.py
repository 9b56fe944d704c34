"""Threads for the compiled kernels, which release the GIL."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

_MIN_CHUNK = 512
"""Fewest problems that are worth a thread of their own."""

_here = threading.local()

_PARTS_EACH = 4
"""Parts of a batch for each processor, at most."""


def in_threads(run: Callable[[slice], None], n_problems: int, least: int = _MIN_CHUNK) -> None:
    """Call a function that releases the GIL on consecutive parts of a batch, on all processors.

    Parameters
    ----------
    run : callable
        Takes a slice of the batch. What it writes must not depend on how the batch is cut. It may call this function,
        which cuts no part again.
    n_problems : int
    least : int
        Fewest problems of a part.
        Optional, default: 512.
    """
    n_parts = n_problems // least
    n_threads = min(n_parts, _n_processors()) if n_parts > 1 else 1
    if n_threads <= 1 or getattr(_here, "is_part", False):
        return run(slice(0, n_problems))
    n_parts = min(n_parts, _PARTS_EACH * n_threads)
    bounds = [n_problems * i // n_parts for i in range(n_parts + 1)]
    parts = iter([slice(start, stop) for start, stop in zip(bounds[:-1], bounds[1:], strict=True)])

    def work() -> None:
        _here.is_part = True
        try:
            for part in parts:  # whoever is free takes the next: a processor may be busy with something else
                run(part)
        finally:
            _here.is_part = False

    others = [_pool(os.getpid()).submit(work) for _ in range(n_threads - 1)]
    work()
    for other in others:
        if not other.cancel():
            other.result()


def _n_processors() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """Keep threads, which take as long to start as a small batch; they do not survive a fork."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="geomstats_anim")
