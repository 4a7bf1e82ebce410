"""What a worker of ``dask.distributed`` does for a batch: it lets a worker process of its own adjust a project.

So a project that runs out of memory, crashes or takes too long ends as on a single machine, and never the worker of
the cluster, whose other work goes on.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import Any

from splinebba_cli import __version__
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.worker_pool import WorkerPool
from splinebba_cli.core.threads import VARIABLE, thread_count

_IDLE_S = 60.0  # after which processes without work are ended

_lock = threading.Lock()
_pools: dict[str, WorkerPool] = {}  # of the batches that this process works for
_timers: dict[str, threading.Timer] = {}


def adjust_on_worker(batch: str, task: dict[str, Any], timeout: float | None) -> dict[str, Any]:
    """The outcome of a task.

    Parameters
    ----------
    batch : str
        Which batch asks.
    task : dict
        :meth:`Task.data`.
    timeout : float, optional
        Seconds.

    Returns
    -------
    dict
        :meth:`Outcome.data`.
    """
    with _lock:
        pool = _pools.setdefault(batch, WorkerPool(_threads()))
    outcome = pool.run(Task.of_data(task), timeout)
    with _lock:
        _cancel_timer(batch)
        timer = _timers[batch] = threading.Timer(_IDLE_S, pool.end_idle)
        timer.daemon = True
        timer.start()
    return outcome.data()


def end_batch(batch: str) -> None:
    """End the processes that work for a batch, or wait for work."""
    with _lock:
        pool = _pools.pop(batch, None)
        _cancel_timer(batch)
    if pool is not None:
        pool.close()


def what_is_here(project: str) -> tuple[str, bool]:
    """Version of the program on this worker, and whether the worker sees a project file."""
    return __version__, Path(project).is_file()


def _cancel_timer(batch: str) -> None:
    timer = _timers.pop(batch, None)
    if timer is not None:
        timer.cancel()


def _threads() -> int:
    """Threads of a project: one, as its place on the worker is that of one thread, if the environment says no more."""
    return thread_count() if os.environ.get(VARIABLE) else 1
