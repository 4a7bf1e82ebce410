"""A worker process: adjusts the projects that it is told, one after the other.

A line of JSON on standard input is a task (:meth:`Task.data`), a line on standard output its outcome
(:meth:`Outcome.data`); the first line, ``{"ready": true}``, says that everything is imported.  What the program or its
libraries print goes to standard error.  An unexpected error ends the process with its traceback there.

The worker ends when its standard input does: when the batch is over, and when the process of the batch was killed.
SIGTERM ends it with what it is at cleaned up; Ctrl-C is left to the process of the batch.
"""

from __future__ import annotations

import faulthandler
import json
import os
import queue
import signal
import sys
import threading
import time
from typing import TextIO

_GRACE_S = 5.0  # for cleaning up


def main() -> None:
    """Entry point of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    faulthandler.enable()
    answers = _own_standard_output()
    tasks: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(tasks,), daemon=True).start()
    from splinebba_cli.batch.adjusting import adjust_task
    from splinebba_cli.batch.plan import Task

    _import_what_is_needed()
    _answer(answers, {"ready": True})
    while (line := tasks.get()) is not None:
        _answer(answers, adjust_task(Task.of_data(json.loads(line))).data())


def _end(signal_number: int, _: object) -> None:
    raise SystemExit(128 + signal_number)


def _own_standard_output() -> TextIO:
    """The standard output as it was; from now on, whatever is printed goes to standard error."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", newline="\n")
    os.dup2(2, 1)
    return answers


def _read(tasks: queue.SimpleQueue[str | None]) -> None:
    """Tasks as they come; where no more can come, the process ends, at work or not."""
    for line in sys.stdin:
        tasks.put(line)
    tasks.put(None)
    signal.raise_signal(signal.SIGTERM)
    time.sleep(_GRACE_S)
    os._exit(0)


def _answer(answers: TextIO, data: dict[str, object]) -> None:
    answers.write(json.dumps(data) + "\n")
    answers.flush()


def _import_what_is_needed() -> None:
    """What :func:`run_adjustment` imports when it is first called: no part of the time of a project."""
    import splinebba_cli.core.adjustment
    import splinebba_cli.output.result_folder
    import splinebba_cli.project.adjusted
    import splinebba_cli.project.loading
    import splinebba_cli.report.build  # noqa: F401
