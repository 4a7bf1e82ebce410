"""The cases of the catalogue: their files, where their mistakes are, what the program says."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml
from rich.cells import cell_len
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.project.plain_text import shown

HERE = Path(__file__).parent
CATALOGUE, BASES = HERE / "catalogue", HERE / "base"
MARK = re.compile("«([^»]*)»")
LONGEST_CARETS = 80  # of a longer passage a part is shown
SAID = re.compile(r"^(?:error|warning|info)\[(SBB\d{3})\]: .*\n(?: *--> (.+)\n)?", re.MULTILINE)
CARETS = re.compile(r"^ *\| *(\^+)$", re.MULTILINE)


@dataclass(frozen=True)
class Finding:
    """A diagnostic: its code, where it points, and how many columns its carets mark (0: not said)."""

    code: str
    place: str
    width: int = 0


@dataclass(frozen=True)
class Case:
    """One broken project of the catalogue."""

    name: str
    content: dict[str, Any]

    @property
    def command(self) -> str:
        """The command that is to refuse it."""
        return str(self.content.get("command", "check"))

    @property
    def exit_code(self) -> int:
        """Exit code of the command."""
        return int(self.content.get("exit", 2))

    def written(self, folder: Path) -> list[Finding]:
        """Write the project into a folder; what is to be found, in the order of `expected`."""
        shutil.copytree(BASES / self.content.get("base", "inline"), folder, dirs_exist_ok=True)
        texts: dict[str, str] = dict(self.content.get("files", {}))
        for change in self.content.get("changes", ()):
            name, old, new = change.get("in", "project.yaml"), change["old"], change["new"]
            text = texts[name] if name in texts else (folder / name).read_text(encoding="utf-8")
            assert MARK.sub(r"\1", text).count(old) == 1, (self.name, old)
            texts[name] = text.replace(old, new)
        marks = []
        for name, text in texts.items():
            marks += list(_marks(name, text))
            plain = MARK.sub(r"\1", text)
            encoding = self.content.get("encoding", {}).get(name, "utf-8")
            (folder / name).write_bytes(plain.encode(encoding, "surrogatepass"))
        for name, what in self.content.get("special", {}).items():
            _make(folder / name, what)
        return self._expected(marks)

    def _expected(self, marks: list[tuple[str, int]]) -> list[Finding]:
        found, rest = [], iter(marks)
        for one in self.content["expected"]:
            code, _, place = one.partition(" ")
            found.append(Finding(code, place) if place else Finding(code, *next(rest, ("no mark", 0))))
        assert next(rest, None) is None, f"{self.name}: more marks than expected codes"
        return found

    def run(self, folder: Path) -> tuple[int, str]:
        """Exit code and what the command finds in the folder of the project; only `check` prints it on stdout."""
        arguments = [
            self.command,
            self.content.get("project", "project.yaml"),
            *self.content.get("options", ()),
        ]
        with chdir(folder):
            result = CliRunner().invoke(app, arguments)
        if self.command != "check":
            return result.exit_code, result.stderr
        counts = result.stdout.find("\nharbour\n") if result.exit_code == 0 else -1
        return result.exit_code, result.stdout if counts < 0 else result.stdout[:counts]

    @property
    def snapshot(self) -> Path:
        """What the program says."""
        return CATALOGUE / self.name / "says.txt"


def _marks(name: str, text: str) -> Iterator[tuple[str, int]]:
    """``file:line:column`` and length of the marked passages."""
    number = 1
    for line in re.split("\r\n|\r|\n", text):
        for found in MARK.finditer(line):
            column = len(MARK.sub(r"\1", line[: found.start()])) + 1
            width = cell_len(shown(found[1].replace("\t", " ")))
            yield f"{name}:{number}:{column}", width if width < LONGEST_CARETS else 0
        number += 1


def _make(path: Path, what: dict[str, Any]) -> None:
    """Files that are no texts."""
    if path.exists() and not path.is_dir():
        path.unlink()
    if "fifo" in what:
        os.mkfifo(path)
    elif "folder" in what:
        path.mkdir()
    elif "link" in what:
        path.symlink_to(what["link"])
    elif "size" in what:
        with path.open("wb") as stream:
            stream.truncate(int(what["size"]))  # no block of it is on the disk
    elif "hex" in what:
        path.write_bytes(bytes.fromhex(what["hex"]))
    elif "parquet" in what:
        _make_parquet(path, what["parquet"], what.get("cut"))


def _make_parquet(path: Path, columns: dict[str, list[Any]], cut: int | None) -> None:
    import pyarrow
    from pyarrow import parquet

    parquet.write_table(pyarrow.table(columns), path)
    if cut is not None:
        path.write_bytes(path.read_bytes()[:cut])


def findings(output: str) -> list[Finding]:
    """What the program has said."""
    starts = [match.start() for match in SAID.finditer(output)] + [len(output)]
    found = []
    for start, end in pairwise(starts):
        match = SAID.match(output, start)
        assert match is not None
        carets = CARETS.search(output, start, end)
        found.append(Finding(match[1], match[2] or "", len(carets[1]) if carets else 0))
    return found


def fits(said: Finding, expected: Finding) -> bool:
    """Whether a diagnostic is the expected one; an empty mark says nothing about the width."""
    same = said.code == expected.code and said.place == expected.place
    return same and expected.width in (0, said.width)


def all_cases() -> list[Case]:
    """The catalogue."""
    folders = sorted(path.parent for path in CATALOGUE.glob("*/case.yaml"))
    return [Case(f.name, yaml.safe_load((f / "case.yaml").read_text(encoding="utf-8"))) for f in folders]
