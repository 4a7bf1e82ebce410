"""The Markdown summary: a whole table whatever names and messages hold, appended, never too long."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from splinebba_cli.batch import step_summary as module
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.step_summary import append_step_summary, asked_for, step_summary
from splinebba_cli.errors import OutputError
from splinebba_cli.project.diagnostics import Diagnostic

GOOD = Outcome(
    "a/project.yaml",
    Verdict.accepted,
    results="a/p",
    seconds=1.23,
    statistics={"sigma0": 1.0, "redundancy": 7},
)
PROBLEM = Diagnostic("SBB201", "error", "unknown key `a|b` <b>*\nnew", "help_me", "b|c/project.yaml", 3, 1)
BAD = Outcome("b|c/project.yaml", Verdict.invalid, problems=(PROBLEM,) * 12)


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.replace(r"\|", "¦").strip("|").split("|")]


def test_table_and_problems() -> None:
    lines = step_summary([GOOD, BAD]).splitlines()
    rows = [line for line in lines if line.startswith("|")]
    assert [len(cells(row)) for row in rows] == [7] * 4
    assert cells(rows[2]) == ["b¦c/project.yaml", "🛑 invalid", "", "", "12", "", "0.0 s"]
    assert cells(rows[3]) == ["a/project.yaml", "✅ accepted", "1.0000", "7", "", "", "1.2 s"]
    items = [line for line in lines if line.startswith("- ")]
    assert items[0] == (
        r"- **error SBB201** unknown key <code>a\|b</code> &lt;b&gt;\* new (b\|c/project.yaml:3:1)<br>help\_me"
    )
    assert len(items) == 11 and items[-1] == "- … and 2 more"
    assert lines.count("</details>") == 1
    assert "up to date" in step_summary([replace(GOOD, up_to_date=True)])


def test_appended(tmp_path: Path) -> None:
    path = tmp_path / "summary.md"
    path.write_text("before\n")
    append_step_summary(path, [GOOD])
    assert path.read_text(encoding="utf-8") == "before\n" + step_summary([GOOD])
    append_step_summary(path, [replace(GOOD, project="caf\udce9.yaml")])
    assert r"| caf\\udce9.yaml |" in path.read_text(encoding="utf-8")
    with pytest.raises(OutputError):
        append_step_summary(tmp_path / "no" / "summary.md", [GOOD])


def test_never_larger_than_github_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_LARGEST", 20_000)
    text = step_summary([replace(BAD, project=f"{number}.yaml") for number in range(100)])
    assert len(text.encode()) < 21_000 and "More problems are in the log" in text
    assert sum(line.startswith("|") for line in text.splitlines()) == 102


def test_the_environment_asks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "a.md")
    assert asked_for() == Path("a.md")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "")
    assert asked_for() is None
