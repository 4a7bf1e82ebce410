"""A command in a process of its own: wall time, processor time and the most memory that it held.

Processor time (user and system, all threads, children included) and memory are the kernel's account of the ended
process (``wait4``).  Linux hands the peak memory of the starting process on to its child: a benchmark that starts
others must stay small itself, or it reports its own memory.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
PYTHON = sys.executable
TUNING = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE", "PYTHONPATH", "SPLINEBBA_SPEED", "SOURCE_DATE_EPOCH")
BYTES_OF_RSS = 1 if sys.platform == "darwin" else 1024


@dataclass(frozen=True)
class Measured:
    """What one process took, and what it printed."""

    wall_s: float
    cpu_s: float
    peak_bytes: int
    output: str


class FailedProcessError(RuntimeError):
    """A measured process ended with another exit code than wanted."""


def environment(threads: int, extra: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment of a measured process: nothing that tunes BLAS or stops clocks, a fixed number of threads."""
    kept = {name: value for name, value in os.environ.items() if name not in TUNING}
    count = str(threads)
    return {
        **kept,
        "OPENBLAS_NUM_THREADS": count,
        "OMP_NUM_THREADS": count,
        "SPLINEBBA_THREADS": count,
        **(extra or {}),
    }


def run_measured(
    command: Sequence[str | Path],
    *,
    threads: int = 2,
    extra: Mapping[str, str] | None = None,
    folder: Path = REPOSITORY,
    accepted: Sequence[int] = (0,),
) -> Measured:
    """Run a command to its end.

    Parameters
    ----------
    extra : environment variables beside those of :func:`environment`
    folder : working directory
    accepted : exit codes that are no failure

    Raises
    ------
    FailedProcessError
        With the end of what the process wrote on its standard error.
    """
    words = [str(word) for word in command]
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        begin = time.perf_counter()
        process = subprocess.Popen(
            words, cwd=folder, env=environment(threads, extra), stdout=output, stderr=errors
        )
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        errors.seek(0)
        if process.returncode not in accepted:
            raise FailedProcessError(
                f"{' '.join(words)}: exit code {process.returncode}\n{errors.read()[-2000:]}"
            )
        printed = output.read()
    return Measured(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * BYTES_OF_RSS, printed)
