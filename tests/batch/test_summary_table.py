"""The table of a batch: the worst first, no column cut, result folders only where they fit."""

from __future__ import annotations

import io

from rich.console import Console

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.summary_table import BatchSummary
from splinebba_cli.project.diagnostics import Diagnostic

ERROR = Diagnostic("SBB201", "error", "unknown key `[red]x`", "remove it", "blocks/b/project.yaml", 3, 2)
WARNING = Diagnostic("SBB305", "warning", "segment without measurements", "", "blocks/a/project.yaml")
OUTCOMES = (
    Outcome("blocks/a/project.yaml", Verdict.accepted, "a", "results/of/all/blocks/a/project.results", True, 0.0,
            {"sigma0": 0.98765, "redundancy": 1234}, [], (WARNING,)),
    Outcome("blocks/b/project.yaml", Verdict.invalid, seconds=0.25, problems=(ERROR,) * 5),
)  # fmt: skip


def printed(width: int, *, all_problems: bool = False) -> list[str]:
    stream = io.StringIO()
    Console(file=stream, width=width).print(BatchSummary(OUTCOMES, all_problems=all_problems))
    return [line.rstrip() for line in stream.getvalue().splitlines()]


def test_problems_then_table_then_count() -> None:
    lines = printed(200)
    assert lines[:4] == [
        "blocks/b/project.yaml: invalid",
        "  error[SBB201] unknown key `[red]x`",
        "    --> blocks/b/project.yaml:3:2",
        "    help: remove it",
    ]
    assert "  … and 2 more (-v shows all)" in lines and lines[-1] == "2 projects: 1 accepted, 1 invalid"
    bad, good = (line.split() for line in lines if line.startswith(" blocks/"))
    assert bad == ["blocks/b/project.yaml", "invalid", "5", "0.2"]
    assert good == [
        "blocks/a/project.yaml", "accepted", "0.9877", "1234", "1", "up", "to", "date", OUTCOMES[0].results,
    ]  # fmt: skip
    assert not any("SBB305" in line for line in lines)


def test_all_problems_of_all() -> None:
    text = "\n".join(printed(200, all_problems=True))
    assert text.count("SBB201") == 5 and text.count("SBB305") == 1 and "more" not in text


def test_narrow_consoles() -> None:
    lines = printed(100)
    assert max(map(len, lines)) <= 100
    assert not any("results/" in line for line in lines)
    assert "result folders left out to fit the width (--dry-run lists them)" in lines
    assert (
        "".join(line[:22].strip() for line in lines if line.startswith(" ")).count("blocks/a/project.yaml")
        == 1
    )
