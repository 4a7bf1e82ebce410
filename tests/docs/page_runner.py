"""A reader who does what a page says, in a folder of their own that begins as a fresh clone's samples."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from tests.docs.page_blocks import Block, commands_of, edited

ROOT = Path(__file__).parents[2]
_OF_SHELL = re.compile(r"[|<>;&*?$`]|\bcd ")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@dataclass
class Reader:
    """What has been done so far, and what the last command printed."""

    folder: Path
    run: Callable[[str], tuple[int, str]]  # a command -> exit code, everything printed
    printed: str = ""
    names: dict[str, Any] = field(default_factory=dict)  # of Python

    def follow(self, block: Block) -> None:
        """Do what a block says.

        Raises
        ------
        AssertionError
            If it does not go as the page says.
        """
        with contextlib.chdir(self.folder):
            if (copied := block.mark("folder")) is not None:
                name, _, source = copied.partition(" from ")
                copy_folder(ROOT / source, self.folder / name)
            elif (file := block.mark("file")) is not None:
                path = Path(file)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(block.text, encoding="utf-8")
            elif (file := block.mark("edit")) is not None:
                path = Path(file)
                path.write_text(edited(path.read_text(encoding="utf-8"), block.text), encoding="utf-8")
            elif block.mark("printed") is not None:
                assert missing_lines(self.printed, block.text) == [], self.printed
            elif block.runs:
                self._run(block)

    def _run(self, block: Block) -> None:
        wanted = int(block.mark("exit code") or 0)
        if block.language == "python":
            self._python(block.text)
            return
        commands = commands_of(block)
        assert commands, "no commands"
        self.printed = ""
        for command in commands:
            code, text = self.run(command)
            self.printed += text
            expected = wanted if command is commands[-1] else 0
            assert code == expected, f"{command}: exit code {code}\n{text}"

    def _python(self, text: str) -> None:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(text, "page", "exec"), self.names)
        self.printed = output.getvalue()


def run_in_process(command: str) -> tuple[int, str]:
    """Exit code and everything printed; commands of the program run in this process, others in a shell."""
    if command.startswith("splinebba ") and not _OF_SHELL.search(command):
        result = CliRunner().invoke(app, shlex.split(command)[1:])
        return result.exit_code, result.output
    return run_in_shell(command)


def run_in_shell(command: str) -> tuple[int, str]:
    """Exit code and everything printed of a command in a shell that finds the program of this environment."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["bash", "-euc", command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=os.environ | {"PATH": path},
        timeout=300,
        check=False,
    )
    return done.returncode, done.stdout.decode()


def missing_lines(printed: str, shown: str) -> list[str]:
    """Lines of a page that were not printed, or not in this order; blanks do not count, `…` is anything.

    Decimals may differ by two units of their last digit, as another machine may round them; counts may not.
    """
    found = [" ".join(line.split()) for line in printed.splitlines()]
    missing, start = [], 0
    for line in (" ".join(line.split()) for line in shown.splitlines()):
        if not line or line == "…":
            continue
        place = next((i for i in range(start, len(found)) if _same(found[i], line)), None)
        if place is None:
            missing.append(line)
        else:
            start = place + 1
    return missing


def _same(found: str, shown: str) -> bool:
    """Whether a line is that of a page: the same words, and the numbers that the page shows."""
    parts = _NUMBER.split(shown)
    words = [re.escape(part).replace("…", ".*") for part in parts]
    numbers = _NUMBER.findall(shown)
    matched = re.fullmatch(r"(-?\d+(?:\.\d+)?)".join(words), found)
    if matched is None:
        return False
    return all(_as_shown(a, b) for a, b in zip(matched.groups(), numbers, strict=True))


def _as_shown(found: str, shown: str) -> bool:
    decimals = len(shown.partition(".")[2])
    if not decimals:
        return found == shown
    return abs(float(found) - float(shown)) <= 2.001 * 10.0**-decimals


def follow_page(blocks: list[Block], reader: Reader) -> None:
    """Do all that a page says, from a fresh copy of the samples on.

    Raises
    ------
    AssertionError
        If something does not go as the page says; names page and line.
    """
    copy_folder(ROOT / "sample_projects", reader.folder / "sample_projects")
    for block in blocks:
        try:
            reader.follow(block)
        except (ValueError, AssertionError) as error:
            raise AssertionError(f"{block.page}:{block.line}: {error}") from error


def copy_folder(source: Path, target: Path) -> None:
    """A folder of the repository without results that lie in it."""
    ignored = shutil.ignore_patterns("*.results", "*.campaign", "*.prediction", "*.simulated")
    shutil.copytree(source, target, ignore=ignored)
