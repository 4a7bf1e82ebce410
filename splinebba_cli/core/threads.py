"""Work in parts, side by side: numpy and compiled kernels release the interpreter while they compute.

The number of threads is that of the cores of the process, or the environment variable SPLINEBBA_THREADS.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

VARIABLE = "SPLINEBBA_THREADS"

Part = TypeVar("Part")
Done = TypeVar("Done")


def thread_count() -> int:
    """How many threads to use, at least one."""
    asked = os.environ.get(VARIABLE, "")
    if asked.isdigit() and int(asked) > 0:
        return int(asked)
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def in_threads(work: Callable[[Part], Done], parts: Sequence[Part]) -> list[Done]:
    """Results of all parts, in their order; the first error of a part is raised.

    Parts must not call :func:`in_threads` themselves: all threads could then wait for each other.
    """
    if len(parts) < 2 or thread_count() == 1:
        return [work(part) for part in parts]
    return list(_pool(thread_count()).map(work, parts))


@lru_cache(maxsize=1)
def _pool(count: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(count, thread_name_prefix="splinebba")
