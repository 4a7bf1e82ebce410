"""Worker processes: their threads, and what becomes of projects whose process is killed, crashes or takes too long."""

from __future__ import annotations

import errno
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from splinebba_cli.batch import worker_pool, worker_process
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.worker_pool import WorkerPool, adjust_locally
from splinebba_cli.jobs.adjust_job import AdjustOptions
from tests.batch.faulty_worker import start_code

MakeTask = Callable[[str], Task]
LONGEST_S = 300.0  # on a loaded machine; those that sleep take twice as long


@pytest.fixture
def task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MakeTask:
    """Tasks by the names that faulty workers know."""
    monkeypatch.setattr(worker_process, "_START", start_code())
    monkeypatch.setattr(worker_process, "_GRACE_S", 1.0)

    def make(name: str) -> Task:
        (tmp_path / name).mkdir(exist_ok=True)
        return Task(Path(name) / "project.yaml", Path(name) / "project.results", tmp_path, AdjustOptions())

    return make


def gone(process: int, seconds: float = 60.0) -> bool:
    """Whether a process is gone, after it was waited for."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def test_each_loss_is_an_outcome_and_the_batch_goes_on(task: MakeTask) -> None:
    names = ["dies", "raises", "crashes", "prints"]
    found = {outcome.project.split("/")[0]: outcome for outcome in adjust_locally([*map(task, names)], 1)}
    assert {name: outcome.verdict for name, outcome in found.items()} == {
        "dies": Verdict.killed, "raises": Verdict.crashed, "crashes": Verdict.crashed, "prints": Verdict.accepted,
    }  # fmt: skip
    (killed,), (raised,), (crashed,) = (found[name].problems for name in names[:3])
    assert (killed.code, killed.message) == ("SBB801", "its process was killed (SIGKILL)")
    assert (raised.code, crashed.code) == ("SBB970", "SBB970")
    assert raised.message.endswith("RuntimeError: a mistake of ours")
    assert "adjust_task" in found["raises"].details  # the traceback
    assert crashed.message.endswith("SIGSEGV") and "string_at" in found["crashes"].details


def test_threads_are_shared_out_and_processes_are_kept(
    task: MakeTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_pool, "thread_count", lambda: 3)
    told = [outcome.details for outcome in adjust_locally([task("tells")] * 6, 2)]
    assert {text.split(maxsplit=2)[2] for text in told} == {"threads 1 BLAS 1"}
    processes = {int(text.split()[1]) for text in told}
    assert len(processes) <= 2
    assert all(map(gone, processes))


def test_time_limit(task: MakeTask) -> None:
    pool = WorkerPool(1)
    begin = time.monotonic()
    limits = {"sleeps": 0.5, "stubborn": 0.5, "tells": 60.0}
    outcomes = [pool.run(task(name), limit) for name, limit in limits.items()]
    assert [outcome.verdict for outcome in outcomes] == [Verdict.timed_out] * 2 + [Verdict.accepted]
    assert time.monotonic() - begin < LONGEST_S
    (problem,) = outcomes[0].problems
    assert (problem.code, problem.message) == ("SBB802", "not finished after 0.5 s")
    pool.close()
    assert pool.run(task("tells")).verdict is Verdict.not_run


def test_leaving_ends_the_processes_at_work(task: MakeTask) -> None:
    begin = time.monotonic()
    outcomes = adjust_locally([task("tells"), task("sleeps"), task("sleeps")], 2)
    first = next(outcomes)
    assert isinstance(first, Outcome) and first.verdict is Verdict.accepted
    outcomes.close()
    assert time.monotonic() - begin < LONGEST_S
    assert gone(int(first.details.split()[1]))


def test_no_process_can_be_started(task: MakeTask, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(*arguments: object, **options: object) -> None:
        raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    monkeypatch.setattr(subprocess, "Popen", refuses)
    (outcome,) = adjust_locally([task("tells")], 1)
    (problem,) = outcome.problems
    assert (outcome.verdict, problem.code) == (Verdict.killed, "SBB801")
    assert problem.message == "no process could be started: Cannot allocate memory"
