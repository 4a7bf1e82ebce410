"""Runs of a campaign in several processes, one BLAS thread each."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, TypeVar

from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.errors import SimulationError

T = TypeVar("T")

_worker: dict[str, Any] = {}  # the task of this process and its limit of threads


def available_processors() -> int:
    """Number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_all(task: Callable[[int], T], numbers: Sequence[int], jobs: int) -> Generator[T, None, None]:
    """Results of ``task(number)`` as they are finished; in this process where `jobs` is 1.

    Parameters
    ----------
    task : picklable; sent to every process once
    jobs : number of processes

    Raises
    ------
    SimulationError
        SBB704, if a process ends without a result (killed, out of memory).

    Notes
    -----
    Where the iteration is left (an exception, Ctrl-C), runs that have not begun are cancelled and the processes are
    ended: what they are at is lost.
    """
    if jobs <= 1 or len(numbers) <= 1:
        with one_thread():
            for number in numbers:
                yield task(number)
        return
    executor = ProcessPoolExecutor(
        min(jobs, len(numbers)), mp_context=get_context("spawn"), initializer=_begin, initargs=(task,)
    )
    before, finished = set(active_children()), False
    try:
        with _no_interruption_of_children():
            futures = [executor.submit(_run, number) for number in numbers]
        for future in as_completed(futures):
            yield future.result()
        finished = True
    except BrokenProcessPool as error:
        help = "finished runs are kept; continue with --resume, and fewer --jobs if memory was short"
        raise SimulationError("SBB704", "a worker process ended unexpectedly", help) from error
    finally:
        if not finished:
            _end(set(active_children()) - before)
        executor.shutdown(wait=True, cancel_futures=True)


def _end(workers: set[BaseProcess]) -> None:
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker.join()


@contextmanager
def _no_interruption_of_children() -> Iterator[None]:
    """Processes that begin here never see Ctrl-C, which a terminal sends to all: the main process ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(task: Callable[[int], Any]) -> None:
    """Prepare a worker: Ctrl-C is left to the main process, and where that is gone, nobody works for it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    limit = one_thread()
    limit.__enter__()
    _worker.update(task=task, limit=limit)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(number: int) -> Any:
    return _worker["task"](number)
