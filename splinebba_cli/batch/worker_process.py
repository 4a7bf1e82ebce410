"""A worker process of a batch, as those see it who give it work.

A worker is a fresh interpreter, never a copy of this process, with its share of the threads, which the environment
gives before BLAS is loaded.  Whatever happens to it reaches its owner as an outcome.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from typing import IO

from splinebba_cli.batch.adjusting import outcome_of_loss
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.core.threads import VARIABLE

_GRACE_S = 2.0  # for cleaning up, before a worker is killed
_TOLD = 20_000  # bytes of what a worker wrote before it died
_START = (
    "import sys, json; sys.path[:] = json.loads(sys.argv.pop()); "
    "from splinebba_cli.batch.worker import main; main()"
)
_THREADS = (
    VARIABLE, "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS",
)  # fmt: skip
# signals of errors of a program, unlike those by which others end it
_OF_ERRORS = frozenset({"SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL", "SIGTRAP", "SIGSYS"})


class WorkerProcess:
    """A process that adjusts one project after the other, until it is ended or dies.

    Parameters
    ----------
    threads : int
        How many it may use.
    """

    def __init__(self, threads: int) -> None:
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 — as long as the process
        self._expired = threading.Event()
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _START, json.dumps([path or os.getcwd() for path in sys.path])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            encoding="utf-8",
            env={**os.environ, **dict.fromkeys(_THREADS, str(threads))},
        )
        self._ready = False

    def run(self, task: Task, timeout: float | None = None) -> Outcome:
        """Adjust a project and wait for what becomes of it.

        Parameters
        ----------
        task : Task
        timeout : float, optional
            Seconds after which the process is ended; its start does not count.

        Returns
        -------
        Outcome
            Also where the process was killed, died or took too long.
        """
        if not self._ready:
            self._ready = self._answer() != ""
        timer = threading.Timer(timeout or 0.0, self._expire)
        if timeout is not None:
            timer.start()
        with suppress(OSError):  # it died: there will be no answer
            self._process.stdin.write(json.dumps(task.data()) + "\n")  # type: ignore[union-attr]
            self._process.stdin.flush()  # type: ignore[union-attr]
        line = self._answer()
        timer.cancel()
        if timeout is not None:
            timer.join()
        if line:
            return Outcome.of_data(json.loads(line))
        if self._expired.is_set():
            return outcome_of_loss(task, Verdict.timed_out, f"not finished after {timeout:g} s")
        return self._loss(task)

    @property
    def alive(self) -> bool:
        """Whether it can take another project."""
        return not self._expired.is_set() and self._process.poll() is None

    def end(self) -> None:
        """End the process, at work or not; one that does not end at once is killed."""
        self._process.terminate()
        try:
            self._process.wait(_GRACE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def close(self) -> None:
        """End the process and free what belongs to it; by its owner, when :meth:`run` has returned."""
        self.end()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]

    def _expire(self) -> None:
        self._expired.set()
        self.end()

    def _answer(self) -> str:
        """A whole line of the worker; empty where it ended before."""
        line = self._process.stdout.readline()  # type: ignore[union-attr]
        return line if line.endswith("\n") else ""

    def _loss(self, task: Task) -> Outcome:
        """The outcome of a project whose process ended by itself, or was ended by others."""
        code = self._process.wait()
        name = _signal_name(-code) if code < 0 else ""
        if code < 0 and name not in _OF_ERRORS:
            return outcome_of_loss(task, Verdict.killed, f"its process was killed ({name})")
        self._errors.seek(max(0, self._errors.seek(0, os.SEEK_END) - _TOLD))
        details = self._errors.read().decode("utf-8", "replace").strip()
        last = details.splitlines()[-1] if details and not name else name or f"exit code {code}"
        return outcome_of_loss(task, Verdict.crashed, f"unexpected error inside the program: {last}", details)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
