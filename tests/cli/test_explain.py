"""``splinebba explain`` as a user runs it."""

from __future__ import annotations

import io
import json
import sys

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.errors import ERROR_CODES


def explain(*arguments: str, expected: int = 0) -> str:
    result = CliRunner().invoke(app, ["explain", *arguments])
    assert result.exit_code == expected, result.output
    return result.output


@pytest.mark.parametrize("text", ["SBB301", "sbb301", "301", " 301"])
def test_ways_to_write_a_code(text: str) -> None:
    assert explain(text).startswith("# SBB301: reference to an unknown id\n")


def test_all_lists_the_codes() -> None:
    listed = dict(line.split("  ", 1) for line in explain("all").splitlines())
    assert listed == ERROR_CODES
    assert explain() == explain("ALL") == explain("all")
    codes = json.loads(explain("all", "--format", "json"))["codes"]
    assert {each["code"]: each["title"] for each in codes} == ERROR_CODES


def test_json() -> None:
    page = json.loads(explain("304", "--format", "json"))
    assert list(page) == ["code", "title", "cause", "example", "cure"]
    assert page["code"] == "SBB304" and "second image" in page["cure"]


def test_unknown_codes_get_near_ones() -> None:
    assert "SBB301 (reference to an unknown id)" in explain("SBB300", expected=2)
    assert "SBB104 (duplicate key)" in explain("duplicate", expected=2)
    assert "no error code `nonsense`" in explain("nonsense", expected=2)
    assert json.loads(explain("399", "--format", "json", expected=2))["problems"][0]["code"] == "SBB900"


def test_on_a_terminal_it_is_laid_out(monkeypatch: pytest.MonkeyPatch) -> None:
    from splinebba_cli.commands import explain as command

    class Terminal(io.StringIO):
        """A standard output that says it is a terminal."""

        def isatty(self) -> bool:
            return True

    shown = Terminal()
    monkeypatch.setattr(sys, "stdout", shown)
    command.explain("SBB301")
    text = shown.getvalue()
    assert "## Cause" not in text and "```" not in text
    assert "Cause" in text and "did you mean `cam`?" in text
