"""A batch from its first project to its last, or to the one that stops it."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.interruption import InterruptedRunError, interruption_of

Adjust = Callable[[Sequence[Task]], Generator[Outcome, None, None]]


@dataclass(frozen=True)
class BatchResult:
    """What became of all projects, in their order; `interruption` is Ctrl-C or SIGTERM, if one ended the batch."""

    outcomes: tuple[Outcome, ...]
    interruption: InterruptedRunError | None


def run_batch(
    tasks: Sequence[Task],
    kept: Callable[[Sequence[Task]], Sequence[Outcome | None]],
    adjust: Adjust,
    *,
    fail_fast: bool,
    tell: Callable[[Outcome], None],
) -> BatchResult:
    """Adjust what has no up-to-date results.

    Parameters
    ----------
    tasks : sequence of Task
    kept : callable
        Gives for every task the outcome that up-to-date results tell, or None.
    adjust : callable
        Gives the outcomes of tasks as they are finished; closed when no more are wanted.
    fail_fast : bool
        Whether the first project that is not accepted stops the batch: the others that are at work are ended.
    tell : callable
        Gets every outcome as soon as it is known.
    """
    known: dict[str, Outcome] = {}
    interruption = None
    try:
        with closing(_in_turn(tasks, kept(tasks), adjust)) as outcomes:
            for outcome in outcomes:
                known[outcome.project] = outcome
                tell(outcome)
                if fail_fast and outcome.verdict is not Verdict.accepted:
                    break
    except KeyboardInterrupt as error:
        interruption = interruption_of(error)
    not_run = (Outcome(str(task.project), Verdict.not_run) for task in tasks)
    return BatchResult(tuple(known.get(each.project, each) for each in not_run), interruption)


def _in_turn(
    tasks: Sequence[Task], kept: Sequence[Outcome | None], adjust: Adjust
) -> Generator[Outcome, None, None]:
    yield from (outcome for outcome in kept if outcome is not None)
    missing = [task for task, outcome in zip(tasks, kept, strict=True) if outcome is None]
    if missing:
        with closing(adjust(missing)) as outcomes:
            yield from outcomes
