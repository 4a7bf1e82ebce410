"""A batch from its first project to its last, or to the one that stops it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task

Adjust = Callable[[Sequence[Task]], Generator[Outcome, None, None]]


@dataclass(frozen=True)
class BatchResult:
    """What became of all projects, in their order; `interrupted` by Ctrl-C or SIGTERM."""

    outcomes: tuple[Outcome, ...]
    interrupted: bool


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
    interrupted = False
    try:
        with closing(_in_turn(tasks, kept(tasks), adjust)) as outcomes:
            for outcome in outcomes:
                known[outcome.project] = outcome
                tell(outcome)
                if fail_fast and outcome.verdict is not Verdict.accepted:
                    break
    except KeyboardInterrupt:
        interrupted = True
    not_run = (Outcome(str(task.project), Verdict.not_run) for task in tasks)
    return BatchResult(tuple(known.get(each.project, each) for each in not_run), interrupted)


def _in_turn(
    tasks: Sequence[Task], kept: Sequence[Outcome | None], adjust: Adjust
) -> Generator[Outcome, None, None]:
    yield from (outcome for outcome in kept if outcome is not None)
    missing = [task for task, outcome in zip(tasks, kept, strict=True) if outcome is None]
    if missing:
        with closing(adjust(missing)) as outcomes:
            yield from outcomes


@contextmanager
def orderly_end() -> Iterator[None]:
    """The first SIGINT or SIGTERM raises KeyboardInterrupt, the second is ignored, the third is as always.

    CI systems send one after the other when a job is cancelled; the second must not disturb the clean end that the
    first one asked for.  A signal that this process was started to ignore (``nohup``, ``&`` in a script) stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    numbers = [number for number in before if before[number] is not signal.SIG_IGN]
    seen: list[int] = []

    def handle(number: int, _: object) -> None:
        seen.append(number)
        if len(seen) == 1:
            raise KeyboardInterrupt
        for each in numbers:
            signal.signal(each, signal.SIG_DFL)

    for number in numbers:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, before[number])
