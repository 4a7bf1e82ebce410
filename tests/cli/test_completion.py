"""Completion in the shell: what the scripts are, and what they are told."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from splinebba_cli.errors import ERROR_CODES

PROGRAM = Path(sys.executable).with_name("splinebba")

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason="the console script is not installed")


def run(*arguments: str, **variables: str) -> str:
    environment = {**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1", **variables}
    return subprocess.run(
        [PROGRAM, *arguments], capture_output=True, text=True, check=True, env=environment
    ).stdout


def in_bash(line: str) -> list[str]:
    """What is offered after a line, by the protocol of the script for bash."""
    words = line.split(" ")
    told = {"COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1), "_SPLINEBBA_COMPLETE": "complete_bash"}
    return run(**told).split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("splinebba adj", ["adjust"]),
        ("splinebba in", ["init"]),
        ("splinebba adjust --format ", ["text", "json", "github"]),
        ("splinebba init --template c", ["close-range", "control-splines"]),
        ("splinebba schema ", ["project", "result", "campaign", "match"]),
        ("splinebba explain SBB10", [code for code in ERROR_CODES if code.startswith("SBB10")]),
        ("splinebba explain 57", ["570"]),
        ("splinebba explain sbb57", ["sbb570"]),
    ],
)
def test_offers(line: str, offered: list[str]) -> None:
    assert in_bash(line) == offered


def test_zsh_and_fish_also_get_the_titles() -> None:
    zsh = run(_SPLINEBBA_COMPLETE="complete_zsh", _TYPER_COMPLETE_ARGS="splinebba explain SBB57")
    assert "SBB570" in zsh and "not enough memory for the normal equations" in zsh
    fish = run(
        _SPLINEBBA_COMPLETE="complete_fish",
        _TYPER_COMPLETE_ARGS="splinebba explain SBB57",
        _TYPER_COMPLETE_FISH_ACTION="get-args",
    )
    assert fish.startswith("SBB570\t")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts(shell: str) -> None:
    script = run("--show-completion", shell)
    assert f"_SPLINEBBA_COMPLETE=complete_{shell}" in script


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_takes_the_script() -> None:
    script = run("--show-completion", "bash")
    told = "COMP_WORDS=(splinebba rep); COMP_CWORD=1"
    code = f"{script}\n{told}; _splinebba_completion '{PROGRAM}'; echo \"${{COMPREPLY[@]}}\""
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["report"]


def test_completion_is_light() -> None:
    """Pressing Tab imports nothing heavy."""
    code = (
        "import sys\n"
        "from splinebba_cli.commands.app import app\n"
        "try: app(prog_name='splinebba')\n"
        "except SystemExit: pass\n"
        "print('LOADED', [m for m in ('numpy', 'yaml', 'jinja2', 'rich.console') if m in sys.modules])\n"
    )
    told = {
        "COMP_WORDS": "splinebba explain SBB57",
        "COMP_CWORD": "2",
        "_SPLINEBBA_COMPLETE": "complete_bash",
    }
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **told}
    )
    assert done.stdout.splitlines() == ["SBB570", "LOADED []"]
