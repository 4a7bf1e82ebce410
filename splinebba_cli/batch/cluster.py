"""A batch on a cluster of ``dask.distributed``, whose workers see the same files under the same names."""

from __future__ import annotations

import queue
import uuid
from collections.abc import Generator, Sequence
from concurrent.futures import CancelledError
from contextlib import closing
from typing import TYPE_CHECKING, Any

from splinebba_cli import __version__
from splinebba_cli.batch.adjusting import outcome_of_loss
from splinebba_cli.batch.cluster_worker import adjust_on_worker, end_batch, what_is_here
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.errors import SplinebbaError

if TYPE_CHECKING:
    from distributed import Client, Future

_CONNECT_S = 20.0
_LOOK_S = 5.0  # how often a silent cluster is looked at
_LOOKS = 12  # without a worker, before it is given up


class ClusterError(SplinebbaError):
    """The scheduler cannot be reached, or its workers cannot adjust."""


def adjust_on_cluster(
    tasks: Sequence[Task], address: str, timeout: float | None
) -> Generator[Outcome, None, None]:
    """Outcomes of tasks as they are finished by the workers of a scheduler.

    Parameters
    ----------
    tasks : sequence of Task
    address : str
        Of the scheduler: ``tcp://host:8786``.
    timeout : float, optional
        Seconds for a project.

    Raises
    ------
    ClusterError
        SBB815, if the package is missing or the scheduler cannot be reached; SBB816, if there are no workers, or they
        have another version of the program, or do not see the projects.

    Notes
    -----
    A project whose worker is lost is given to another one; one that loses several is given up (`allowed-failures` of
    the scheduler's configuration).  Where the iteration is left, the processes of this batch are ended.
    """
    batch = uuid.uuid4().hex
    with closing(_connected(address)) as client:
        _require_able_workers(client, tasks[0])
        finished: queue.SimpleQueue[Future] = queue.SimpleQueue()
        waiting: dict[str, Task] = {}
        futures = []
        try:
            for number, task in enumerate(tasks):
                key = f"splinebba-{batch}-{number}"
                future = client.submit(adjust_on_worker, batch, task.data(), timeout, key=key, pure=False)
                waiting[key] = task
                futures.append(future)  # a future that nobody holds is forgotten by the scheduler
                future.add_done_callback(finished.put)
            yield from _finished(client, finished, waiting)
        finally:
            _end(client, futures, batch)


def _finished(
    client: Client, finished: queue.SimpleQueue[Future], waiting: dict[str, Task]
) -> Generator[Outcome, None, None]:
    """Outcomes as they come; of all that wait where nothing can come any more."""
    empty = 0
    while waiting:
        try:
            future = finished.get(timeout=_LOOK_S)
        except queue.Empty:
            empty = 0 if _workers(client) else empty + 1
            if client.status == "running" and empty < _LOOKS:
                continue
            reason = "no worker is left on the cluster" if empty >= _LOOKS else "the scheduler ended"
            yield from (outcome_of_loss(task, Verdict.killed, reason) for task in waiting.values())
            return
        yield _outcome(future, waiting.pop(future.key))


def _outcome(future: Future, task: Task) -> Outcome:
    if future.status == "error":
        error = future.exception()
        if type(error).__name__ == "KilledWorker":
            return outcome_of_loss(task, Verdict.killed, "every worker that it was given to was lost")
        return outcome_of_loss(task, Verdict.crashed, f"{type(error).__name__}: {error}")
    try:
        return Outcome.of_data(future.result())
    except (CancelledError, OSError):
        return outcome_of_loss(task, Verdict.killed, "the scheduler ended")


def _connected(address: str) -> Client:
    try:
        from distributed import Client
    except ImportError as error:
        help = "pip install 'splinebba[distributed]'"
        raise ClusterError("SBB815", "--scheduler needs the package distributed", help) from error
    try:
        return Client(address, timeout=_CONNECT_S, set_as_default=False, name="splinebba-batch")
    except (OSError, ValueError, TypeError) as error:
        help = "is it running, and is the address the one that it tells: tcp://host:8786?"
        raise ClusterError("SBB815", f"no scheduler answers at {address}", help) from error


def _require_able_workers(client: Client, task: Task) -> None:
    """Every worker has this version of the program and sees the first project."""
    try:
        client.wait_for_workers(1, timeout=_CONNECT_S)
    except OSError as error:
        help = "start some: dask worker ADDRESS"
        raise ClusterError("SBB816", "the scheduler has no workers", help) from error
    found = client.run(what_is_here, str(task.project_file), on_error="return")
    for worker, answer in found.items():
        if isinstance(answer, OSError):
            continue  # lost in between
        if isinstance(answer, BaseException):
            help = "install the same version of splinebba where the workers run"
            raise ClusterError("SBB816", f"worker {worker} cannot import the program: {answer}", help)
        version, seen = answer
        if version != __version__:
            help = "install the same version where the workers run"
            message = f"worker {worker} has splinebba {version}, not {__version__}"
            raise ClusterError("SBB816", message, help)
        if not seen:
            help = "workers must see the same files under the same names: a shared file system"
            raise ClusterError("SBB816", f"worker {worker} does not see {task.project_file}", help)


def _workers(client: Client) -> dict[str, Any]:
    """Threads of every worker; none where the scheduler does not answer."""
    try:
        return dict(client.nthreads())
    except (OSError, ValueError, RuntimeError):
        return {}


def _end(client: Client, futures: list[Future], batch: str) -> None:
    """Cancel what has not begun, end what is at work, free the processes."""
    if client.status != "running":
        return
    client.cancel([future for future in futures if not future.done()])
    client.run(end_batch, batch, on_error="ignore")
