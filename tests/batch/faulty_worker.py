"""A worker process in which some projects misbehave, by the name of their folder.

The processes of a batch start it instead of the real one where a test has put :func:`start_code` in its place.
"""

from __future__ import annotations

import ctypes
import os
import signal
import time
from dataclasses import replace

from splinebba_cli.batch import adjusting, worker, worker_process
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task


def start_code() -> str:
    """What the interpreter of a faulty worker is started with."""
    real = "from splinebba_cli.batch.worker import main"
    assert real in worker_process._START
    return worker_process._START.replace(real, f"from {__name__} import main")


def main() -> None:
    real = adjusting.adjust_task

    def adjust_task(task: Task) -> Outcome:
        name = task.project.parent.name
        if name == "dies":
            os.kill(os.getpid(), signal.SIGKILL)
        if name == "crashes":
            ctypes.string_at(0)
        if name == "raises":
            raise RuntimeError("a mistake of ours")
        begun = task.project_file.with_name("begun")
        again = begun.exists()
        begun.write_text(str(os.getpid()))
        if name == "sleeps":
            time.sleep(600.0)
        if name == "loses its worker" or (name == "loses its worker once" and not again):
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(600.0)
        if name == "stubborn":
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            time.sleep(600.0)
        if name == "prints":
            os.write(1, b"not an outcome\n")
        if name in ("tells", "prints", "loses its worker once"):
            return replace(Outcome(str(task.project), Verdict.accepted), details=_about_this_process())
        return real(task)

    adjusting.adjust_task = adjust_task
    worker._import_what_is_needed = lambda: None  # what is not needed here starts faster
    worker.main()


def _about_this_process() -> str:
    from threadpoolctl import threadpool_info

    from splinebba_cli.core.threads import thread_count

    blas = {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}
    return f"process {os.getpid()} threads {thread_count()} BLAS {max(blas)}"
