"""A batch on a local cluster of dask.distributed: the same outcomes, lost workers, time limit, clear refusals."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from splinebba_cli.batch import cluster as module
from splinebba_cli.batch.cluster import ClusterError, adjust_on_cluster
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.jobs.adjust_job import AdjustOptions

distributed = pytest.importorskip("distributed", reason="the extra `distributed` is not installed")

MakeTask = Callable[[str], Task]
PRELOAD = str(Path(__file__).with_name("cluster_preload.py"))  # faulty workers


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The scheduler of two processes; a project that loses two workers is given up."""
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50, preload=[PRELOAD]
        ) as cluster,
    ):
        yield cluster.scheduler_address


@pytest.fixture
def task(tmp_path: Path) -> MakeTask:
    """Tasks by the names that faulty workers know."""

    def make(name: str) -> Task:
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / name / "project.yaml").touch()
        return Task(Path(name) / "project.yaml", Path(name) / "project.results", tmp_path, AdjustOptions())

    return make


def verdicts(outcomes: Iterator[Outcome]) -> dict[str, Verdict]:
    return {outcome.project.split("/")[0]: outcome.verdict for outcome in outcomes}


def test_outcomes_are_those_of_a_single_machine(address: str, task: MakeTask) -> None:
    names = ("tells", "dies", "raises", "sleeps")
    found = verdicts(adjust_on_cluster([task(name) for name in names], address, 4.0))
    assert found == {
        "tells": Verdict.accepted, "dies": Verdict.killed, "raises": Verdict.crashed, "sleeps": Verdict.timed_out,
    }  # fmt: skip


def test_leaving_ends_the_processes_on_the_workers(address: str, task: MakeTask) -> None:
    sleeping = task("sleeps")
    begun = sleeping.project_file.with_name("begun")
    outcomes = adjust_on_cluster([task("tells"), sleeping], address, None)
    assert next(outcomes).verdict is Verdict.accepted
    end = time.monotonic() + 120.0
    while not (begun.exists() and begun.read_text()) and time.monotonic() < end:
        time.sleep(0.05)
    outcomes.close()
    with pytest.raises(ProcessLookupError):
        os.kill(int(begun.read_text()), 0)


def refused(task: Task, address: str) -> ClusterError:
    with pytest.raises(ClusterError) as caught:
        next(adjust_on_cluster([task], address, None))
    return caught.value


def test_workers_that_cannot_adjust(address: str, task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere = replace(task("tells"), folder=Path("/nowhere"))
    error = refused(elsewhere, address)
    assert error.code == "SBB816" and "does not see /nowhere/tells/project.yaml" in error.message
    monkeypatch.setattr(module, "__version__", "99.0")
    error = refused(task("tells"), address)
    assert error.code == "SBB816" and "99.0" in error.message


def test_projects_of_lost_workers(address: str, task: MakeTask) -> None:
    (again,) = adjust_on_cluster([task("loses its worker once")], address, None)
    (given_up,) = adjust_on_cluster([task("loses its worker")], address, None)
    assert (again.verdict, given_up.verdict) == (Verdict.accepted, Verdict.killed)
    assert given_up.problems[0].message == "every worker that it was given to was lost"


def test_scheduler_without_workers(task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CONNECT_S", 1.0)
    with distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0") as cluster:
        error = refused(task("tells"), cluster.scheduler_address)
    assert (error.code, error.message) == ("SBB816", "the scheduler has no workers")


def test_no_scheduler(task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CONNECT_S", 1.0)
    for address in ("tcp://127.0.0.1:9", "nonsense", "http://127.0.0.1:9"):
        error = refused(task("tells"), address)
        assert (error.code, error.message) == ("SBB815", f"no scheduler answers at {address}")


def test_without_the_package(task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    error = refused(task("tells"), "tcp://127.0.0.1:9")
    assert error.code == "SBB815" and "splinebba[distributed]" in error.help


def test_a_cluster_that_vanishes(task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_LOOK_S", 0.5)
    cluster: Any = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=":0", silence_logs=50, preload=[PRELOAD]
    )
    outcomes = adjust_on_cluster([task("tells"), task("sleeps")], cluster.scheduler_address, None)
    first = next(outcomes)
    cluster.close()
    (second,) = outcomes
    assert (first.verdict, second.verdict) == (Verdict.accepted, Verdict.killed)
    assert second.problems[0].message == "the scheduler ended"
