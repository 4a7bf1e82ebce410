"""Campaigns that are interrupted or killed: no process is left, finished runs are kept, and they are resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.kill_nine import listening
from splinebba_cli.output.run_log import campaign_folder
from tests.cli.command_cases import run

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="processes of Linux")
LONGEST_S = 120.0
RUNS = 12


def arguments(out: Path, jobs: int) -> list[str]:
    return [
        "simulate",
        "strip",
        "--runs",
        str(RUNS),
        "--jobs",
        str(jobs),
        "-o",
        str(out),
        "--figures",
        "none",
    ]


def start(out: Path) -> subprocess.Popen[str]:
    """A campaign in a process group of its own, as a shell begins it, when its first run is finished."""
    process = subprocess.Popen(
        [sys.executable, "-m", "splinebba_cli", *arguments(out, 2)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=listening,
    )  # fmt: skip
    end = time.monotonic() + LONGEST_S
    while time.monotonic() < end and process.poll() is None and finished(out) < 1:
        time.sleep(0.01)
    return process


def finished(out: Path) -> int:
    log = out / "runs.jsonl"
    return max(0, log.read_bytes().count(b"\n") - 1) if log.exists() else 0


def alive(group: int) -> list[int]:
    """Processes of a group that still run."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, _, session = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            except OSError:
                continue
            if int(session) == group and state != "Z":
                found.append(int(entry.name))
    return found


def all_gone(group: int) -> bool:
    end = time.monotonic() + LONGEST_S
    while alive(group) and time.monotonic() < end:
        time.sleep(0.02)
    return not alive(group)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)]
)
def test_ended_campaigns_are_resumed(tmp_path: Path, number: int, code: int) -> None:
    out = tmp_path / "campaign"
    process = start(out)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # a terminal tells all processes
    else:
        process.send_signal(number)
    _, err = process.communicate(timeout=LONGEST_S)
    assert process.returncode == code, err
    assert "Traceback" not in err
    assert all_gone(process.pid), "workers are left"
    kept = finished(out)
    assert 1 <= kept < RUNS
    if number != signal.SIGKILL:
        assert f"{kept} of {RUNS} runs are kept, --resume continues" in err
        assert [entry.name for entry in out.iterdir()] == ["runs.jsonl"]
    resumed = run(*arguments(out, 1), "--resume")
    assert resumed.exit_code == 0, resumed.output
    assert {entry.name for entry in out.iterdir()} == {"runs.jsonl", "campaign.json"}
    if number == signal.SIGINT:
        assert run(*arguments(tmp_path / "straight", 1)).exit_code == 0
        at_once = (tmp_path / "straight" / "campaign.json").read_bytes()
        assert (out / "campaign.json").read_bytes() == at_once


def test_a_second_campaign_in_the_same_folder_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    with campaign_folder(out):
        refused = run(*arguments(out, 1), "--force")
    assert refused.exit_code == 2 and "error[SBB606]: another run is writing" in refused.stderr
    assert list(tmp_path.iterdir()) == []
