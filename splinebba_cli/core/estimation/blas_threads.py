"""One BLAS thread for small fronts, where more threads cost more than they bring."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache
from importlib import import_module
from itertools import groupby
from typing import Any

LARGE_FRONT = 2000
"""Fronts of at least so many unknowns (pivots and rows) use all threads.

Fronts of 900 to 1600 gain nothing from two threads on an idle machine (10 000 images: 0.7 s either
way) and lose several times that where the cores are shared.
"""


@lru_cache(maxsize=1)
def _controller() -> Any:
    """The thread pools of the loaded BLAS libraries; None without threadpoolctl."""
    try:
        return import_module("threadpoolctl").ThreadpoolController()
    except ImportError:
        return None


@lru_cache(maxsize=1)
def _all_threads() -> int:
    """Threads that BLAS has where nobody has limited it."""
    controller = _controller()
    return max((library["num_threads"] for library in controller.info()), default=1) if controller else 1


def one_thread() -> AbstractContextManager[Any]:
    """A context in which BLAS runs in one thread; without threadpoolctl it has no effect.

    A product of vectors of some ten thousand numbers already wakes all threads, which then wait for each other longer
    than they compute.
    """
    controller, _ = _controller(), _all_threads()
    return nullcontext() if controller is None else controller.limit(limits=1, user_api="blas")


def all_threads() -> AbstractContextManager[Any]:
    """A context in which BLAS has all of its threads again."""
    controller = _controller()
    return nullcontext() if controller is None else controller.limit(limits=_all_threads(), user_api="blas")


def fronts_with_threads(fronts: Iterable[int], unknowns: list[int]) -> Iterator[int]:
    """The fronts in their order; while a small one is out, BLAS runs in one thread.

    Parameters
    ----------
    fronts : iterable of int
    unknowns : list of int
        Pivots and rows of each front together.
    """
    for large, run in groupby(fronts, key=lambda front: unknowns[front] >= LARGE_FRONT):
        with all_threads() if large else one_thread():
            yield from run
