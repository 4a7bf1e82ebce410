"""The examples of the explanation pages, run as their readers would.

A fenced block of ``yaml`` replaces those sections of ``project.yaml`` beside this module that it has.  A block whose
first line is ``# NAME`` is the whole file NAME; one of ``json`` is the file that the command names last.  A ``console``
block holds a command after ``$``, and below it what the program says about the code of the page.
"""

from __future__ import annotations

import re
import shlex
from contextlib import chdir
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from typer.testing import CliRunner

from splinebba_cli.commands.app import app

PAGES = Path(str(files("splinebba_cli"))) / "explanations"
BASE = Path(__file__).with_name("project.yaml").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A command with its files, and what it prints."""

    code: str
    command: str
    files: dict[str, str]
    output: str  # as the page has it


def example_of(page: Path) -> Example | None:
    """The example of a page that can be run; None where it has none."""
    section = page.read_text(encoding="utf-8").partition("\n## Example\n")[2].partition("\n## ")[0]
    blocks = BLOCK.findall(section + "\n")
    console = next((text for kind, text in blocks if kind == "console"), None)
    if console is None:
        return None
    head, _, output = console.partition("\n")
    command = head.removeprefix("$ ")
    found = {}
    for kind, text in blocks:
        named = re.match(r"# ([\w. -]+\.\w+)\n", text)
        if kind in ("yaml", "csv") and named:
            found[named.group(1)] = text
        elif kind == "yaml":
            found["project.yaml"] = with_sections(BASE, text)
        elif kind == "json":
            found[shlex.split(command)[-1]] = text
    return Example(page.stem, command, found, output.rstrip("\n"))


def with_sections(project: str, fragment: str) -> str:
    """The project with the sections of a fragment in place of its own."""
    own, new = _sections(project), _sections(fragment)
    return "".join({**own, **new}.values())


def _sections(text: str) -> dict[str, str]:
    parts = re.split(r"^(?=\w+:)", text, flags=re.MULTILINE)
    return {part.partition(":")[0]: part for part in parts if part.strip()}


def printed(example: Example, folder: Path) -> str:
    """What the program says about the code of the page: its paragraphs that begin with it."""
    for name, text in example.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    with chdir(folder):
        result = CliRunner().invoke(app, shlex.split(example.command)[1:])
    paragraphs = re.split(r"\n\n", result.output.strip("\n"))
    about = re.compile(rf"^(error|warning|info)\[{example.code}\]", re.MULTILINE)
    starts = [(text, about.search(text)) for text in paragraphs]  # lines of progress may stand before
    return "\n\n".join(text[start.start() :].rstrip() for text, start in starts if start)
