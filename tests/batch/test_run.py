"""The order of a batch: kept results first, stops where it is told to, and ends in an orderly way."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from pathlib import Path

import pytest

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.run import BatchResult, run_batch
from splinebba_cli.interruption import watch_for_interruption
from splinebba_cli.jobs.adjust_job import AdjustOptions

TASKS = [Task(Path(f"{name}.yaml"), Path(f"{name}.results"), Path("/"), AdjustOptions()) for name in "abcd"]


def run(
    verdicts: dict[str, Verdict],
    *,
    kept: Sequence[Outcome | None] = (None,) * len(TASKS),
    fail_fast: bool = False,
    before: Callable[[str], None] = lambda name: None,
) -> tuple[BatchResult, list[str]]:
    """The result, and what was begun; outcomes come in the reversed order of the tasks."""
    begun: list[str] = []

    def adjust(tasks: Sequence[Task]) -> Generator[Outcome, None, None]:
        try:
            for task in reversed(tasks):
                begun.append(task.project.stem)
                before(task.project.stem)
                yield Outcome(str(task.project), verdicts.get(task.project.stem, Verdict.accepted))
        finally:
            begun.append("closed")

    told: list[Outcome] = []
    result = run_batch(TASKS, lambda _: kept, adjust, fail_fast=fail_fast, tell=told.append)
    run_ones = [outcome for outcome in result.outcomes if outcome.verdict is not Verdict.not_run]
    assert sorted(outcome.project for outcome in told) == [outcome.project for outcome in run_ones]
    return result, begun


def verdicts(result: BatchResult) -> str:
    marks = {Verdict.accepted: "+", Verdict.not_run: ".", Verdict.invalid: "x"}
    return "".join(marks[outcome.verdict] for outcome in result.outcomes)


def test_goes_on_after_failures_in_the_order_of_the_tasks() -> None:
    result, begun = run({"c": Verdict.invalid})
    assert [outcome.project for outcome in result.outcomes] == ["a.yaml", "b.yaml", "c.yaml", "d.yaml"]
    assert verdicts(result) == "++x+" and result.interruption is None
    assert begun == ["d", "c", "b", "a", "closed"]


def test_fail_fast_stops() -> None:
    result, begun = run({"c": Verdict.invalid}, fail_fast=True)
    assert verdicts(result) == "..x+" and begun == ["d", "c", "closed"]


def test_kept_results_are_not_made_again() -> None:
    kept = [
        None,
        Outcome("b.yaml", Verdict.accepted, up_to_date=True),
        None,
        Outcome("d.yaml", Verdict.invalid),
    ]
    result, begun = run({}, kept=kept)
    assert verdicts(result) == "+++x" and begun == ["c", "a", "closed"]
    stopped, begun = run({}, kept=kept, fail_fast=True)
    assert verdicts(stopped) == ".+.x" and begun == []
    _, begun = run({}, kept=[Outcome(str(task.project), Verdict.accepted) for task in TASKS])
    assert begun == []


@pytest.fixture
def watched() -> Iterator[None]:
    """Signals end a run as they do in the program; not ignored, as they are in jobs in the background."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in (signal.SIGINT, signal.SIGTERM)}
    watch_for_interruption()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("watched")
@pytest.mark.parametrize(("number", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_batch_and_the_second_does_not_disturb(number: int, exit_code: int) -> None:
    def interrupt(name: str) -> None:
        if name == "b":
            os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)

    result, begun = run({}, before=interrupt)
    assert verdicts(result) == "..++" and begun == ["d", "c", "b", "closed"]
    assert result.interruption is not None and result.interruption.exit_code == exit_code


def test_interrupted_while_results_are_looked_at() -> None:
    def looks(_: Sequence[Task]) -> Sequence[Outcome | None]:
        raise KeyboardInterrupt

    def adjust(_: Sequence[Task]) -> Generator[Outcome, None, None]:
        pytest.fail("nothing may begin")

    result = run_batch(TASKS, looks, adjust, fail_fast=False, tell=pytest.fail)
    assert verdicts(result) == "...." and result.interruption is not None
