"""Times and memory of a measured process are its own; its environment is the stated one."""

from __future__ import annotations

import json
import resource
import time

import pytest

from benchmarks.measured_process import BYTES_OF_RSS, PYTHON, FailedProcessError, run_measured

MIB = 2**20


def test_memory_and_processor_time_of_the_child_are_reported() -> None:
    code = "import time; held = bytearray(300 * 2**20); end = time.process_time() + 0.3\n"
    measured = run_measured([PYTHON, "-c", code + "while time.process_time() < end: pass"])
    handed_on = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_OF_RSS
    assert (
        300 * MIB <= measured.peak_bytes < max(400 * MIB, handed_on + 50 * MIB)
    )  # Python itself takes some 10
    assert measured.cpu_s >= 0.3
    assert measured.wall_s >= 0.3


def test_waiting_takes_wall_time_and_no_processor_time() -> None:
    begin = time.perf_counter()
    measured = run_measured([PYTHON, "-c", "import time; time.sleep(0.5)"])
    assert 0.5 <= measured.wall_s <= time.perf_counter() - begin
    assert measured.cpu_s < 0.4


def test_environment_of_a_child(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_CORETYPE", "PRESCOTT")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    code = "import json, os; print(json.dumps(dict(os.environ)))"
    found = json.loads(run_measured([PYTHON, "-c", code], threads=3, extra={"DUMP": "here"}).output)
    assert "OPENBLAS_CORETYPE" not in found
    assert found["OPENBLAS_NUM_THREADS"] == found["OMP_NUM_THREADS"] == found["SPLINEBBA_THREADS"] == "3"
    assert found["DUMP"] == "here"


def test_a_failed_process_says_what_it_wrote() -> None:
    with pytest.raises(FailedProcessError, match="exit code 4\nno such block"):
        run_measured([PYTHON, "-c", "import sys; sys.stderr.write('no such block'); sys.exit(4)"])
    assert run_measured([PYTHON, "-c", "import sys; sys.exit(1)"], accepted=(0, 1)).output == ""
