"""The README of the benchmarks names all of them, with and without a command."""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"


def test_every_file_is_named() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    commands = set(re.findall(r"^\| `(\w+)", text, re.MULTILINE))
    parts = set(re.findall(r"`(\w+)`", text.split("## Parts without a command")[1]))
    found = {path.stem: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.py")}
    with_command = {name for name, code in found.items() if 'if __name__ == "__main__"' in code}
    assert commands == with_command
    assert parts == set(found) - with_command
