"""Results that find no way out: a pipe whose reader has gone, a file without room."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.batch.sample_copies import not_accepted

FULL = Path("/dev/full")


def without_reader(*arguments: str) -> subprocess.CompletedProcess[bytes]:
    """The program, its standard output a pipe that nobody reads."""
    read, write = os.pipe()
    os.close(read)
    try:
        return run(*arguments, stdout=write)
    finally:
        os.close(write)


def run(*arguments: str, stdout: int) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "splinebba_cli", *arguments]
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, check=False)


@pytest.mark.parametrize("arguments", [("schema", "project"), ("explain", "SBB301"), ("--version",)])
def test_a_reader_that_has_gone_is_no_error(arguments: tuple[str, ...]) -> None:
    ended = without_reader(*arguments)
    assert (ended.returncode, ended.stderr) == (0, b"")


def test_the_verdict_is_told_although_nobody_reads(tmp_path: Path) -> None:
    project = not_accepted(tmp_path / "block")
    ended = without_reader("adjust", str(project), "--no-html", "-q")
    assert (ended.returncode, ended.stderr) == (1, b"")
    assert (tmp_path / "block" / "project.results" / "result.json").exists()


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("arguments", [("schema", "project"), ("explain", "SBB301")])
def test_a_file_without_room_is_one(arguments: tuple[str, ...]) -> None:
    with FULL.open("wb") as stream:
        ended = run(*arguments, stdout=stream.fileno())
    assert ended.returncode == 2
    assert b"error[SBB604]: cannot write what is printed" in ended.stderr
    assert b"Traceback" not in ended.stderr
