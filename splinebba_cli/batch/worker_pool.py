"""Worker processes that are kept between projects, and replaced when they die."""

from __future__ import annotations

import threading
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed

from splinebba_cli.batch.adjusting import outcome_of_loss
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.worker_process import WorkerProcess
from splinebba_cli.core.threads import thread_count


class WorkerPool:
    """As many worker processes as callers at the same time.

    Parameters
    ----------
    threads : int
        How many each of them may use.
    """

    def __init__(self, threads: int) -> None:
        self._threads = threads
        self._lock = threading.Lock()
        self._idle: list[WorkerProcess] = []
        self._busy: set[WorkerProcess] = set()
        self._closed = False

    def run(self, task: Task, timeout: float | None = None) -> Outcome:
        """Adjust a project in a process that is idle, or in a new one; see :meth:`WorkerProcess.run`."""
        with self._lock:
            if self._closed:
                return Outcome(str(task.project), Verdict.not_run)
            try:
                worker = self._idle.pop() if self._idle else WorkerProcess(self._threads)
            except OSError as error:  # no memory, no more processes, no temporary file
                return outcome_of_loss(task, Verdict.killed, f"no process could be started: {error.strerror}")
            self._busy.add(worker)
        outcome = worker.run(task, timeout)
        with self._lock:
            self._busy.discard(worker)
            kept = worker.alive and not self._closed
            if kept:
                self._idle.append(worker)
        if not kept:
            worker.close()
        return outcome

    def end_idle(self) -> None:
        """End the processes that have no work."""
        with self._lock:
            idle, self._idle = self._idle, []
        for worker in idle:
            worker.close()

    def close(self) -> None:
        """End all processes; what they are at is lost."""
        with self._lock:
            self._closed = True
            busy = list(self._busy)
        for worker in busy:
            worker.end()
        self.end_idle()


def adjust_locally(
    tasks: Sequence[Task], jobs: int, timeout: float | None = None
) -> Generator[Outcome, None, None]:
    """Outcomes of tasks as they are finished by processes of this machine.

    Parameters
    ----------
    tasks : sequence of Task
    jobs : int
        Number of processes; the threads of this process (:func:`thread_count`) are shared out among them.
    timeout : float, optional
        Seconds for a project.

    Notes
    -----
    Where the iteration is left (``close``, Ctrl-C), the processes are ended.
    """
    jobs = max(1, min(jobs, len(tasks)))
    pool = WorkerPool(max(1, thread_count() // jobs))
    executor = ThreadPoolExecutor(jobs, thread_name_prefix="batch")
    try:
        for future in as_completed([executor.submit(pool.run, task, timeout) for task in tasks]):
            yield future.result()
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        pool.close()
        executor.shutdown(wait=True)
