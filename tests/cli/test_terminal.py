"""The console of a real terminal: colours, a line of progress that goes away, widths, Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.kill_nine import digest
from tests.cli.command_cases import run
from tests.cli.terminal import run_in_terminal, screen_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals of POSIX")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("terminal") / "block"
    assert run("simulate", "strip", "-o", folder, "--seed", 1).exit_code == 0
    return folder


def piped(arguments: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
    names = {"NO_COLOR", "FORCE_COLOR", "COLUMNS"}
    kept = {name: value for name, value in os.environ.items() if name not in names}
    return subprocess.run(
        [sys.executable, "-m", "splinebba_cli", *arguments],
        env=kept | environment,
        capture_output=True,
        text=True,
    )


def test_progress_appears_and_goes_away_and_results_are_coloured(project: Path, tmp_path: Path) -> None:
    arguments = ["adjust", str(project), "-o", str(tmp_path / "out"), "--no-html"]
    shown = run_in_terminal(arguments, columns=120)
    assert shown.code == 0, shown.raw
    assert "approximate values" in shown.raw and "adjustment" in shown.raw, "no progress"
    assert shown.raw.count("\x1b[?25l") == shown.raw.count("\x1b[?25h"), "the cursor is gone"
    assert shown.coloured
    found = piped(arguments)
    assert found.returncode == 0
    assert "\n".join(shown.screen).strip() == "\n".join(map(str.rstrip, found.stdout.splitlines())).strip()
    assert "\x1b" not in found.stdout + found.stderr and "\r" not in found.stdout + found.stderr


@pytest.mark.parametrize(
    ("environment", "coloured", "live"),
    [
        ({"NO_COLOR": "1"}, False, True),
        ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False, True),
        ({"NO_COLOR": ""}, True, True),
        ({"TERM": "dumb"}, False, False),
    ],
    ids=str,
)
def test_environment_of_a_terminal(
    project: Path, environment: dict[str, str], coloured: bool, live: bool
) -> None:
    shown = run_in_terminal(["check", str(project)], environment=environment)
    assert shown.code == 0
    assert shown.coloured is coloured
    assert ("\x1b[?25l" in shown.raw) is live


def test_colours_can_be_forced_into_a_pipe(project: Path) -> None:
    assert "\x1b[" in piped(["check", str(project)], FORCE_COLOR="1").stdout
    assert "\x1b[" not in piped(["check", str(project)], FORCE_COLOR="0").stdout
    assert "\x1b[" not in piped(["check", str(project)], FORCE_COLOR="1", NO_COLOR="1").stdout


def test_width(project: Path) -> None:
    narrow = run_in_terminal(["check", str(project)], columns=70)
    tables = [line for line in narrow.screen if line.startswith(" ───")]
    assert tables and max(map(len, tables)) <= 70
    again = run_in_terminal(["check", str(project)], columns=120, environment={"COLUMNS": "70"})
    assert again.screen == narrow.screen
    assert piped(["check", str(project)], COLUMNS="70").stdout == piped(["check", str(project)]).stdout


def test_quiet_is_quiet_in_a_terminal(project: Path) -> None:
    assert "\x1b[?25l" not in run_in_terminal(["check", str(project), "-q"]).raw


@pytest.mark.parametrize(
    ("number", "code", "name"), [(signal.SIGINT, 130, "Ctrl-C"), (signal.SIGTERM, 143, "SIGTERM")]
)
@pytest.mark.parametrize("moment", ["starting", "writing"])
def test_interruption(project: Path, tmp_path: Path, number: int, code: int, name: str, moment: str) -> None:
    target = tmp_path / "out"
    assert run("adjust", project, "-o", target, "--no-html", "-q").exit_code == 0
    before = digest(target)
    shown = run_in_terminal(["adjust", str(project), "-o", str(target)], interrupt_at=moment, number=number)
    assert shown.code == code, shown.raw
    assert shown.screen[-2:] == [f"interrupted by {name}; files are as they were, or complete", ""]
    assert "Traceback" not in shown.raw
    assert digest(target) == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["out"]


def test_the_screen_of_the_tests() -> None:
    assert screen_of("abc\rx\r\n\x1b[1mbold\x1b[0m\r\x1b[2Kz\r\n\x1b[1A\x1b[2K!") == ["xbc", "!", ""]
