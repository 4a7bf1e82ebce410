"""Problems of a result point at the line of the project that they are about."""

from __future__ import annotations

from pathlib import Path

from splinebba_cli.core.result import Problem
from splinebba_cli.project.annotations import problem_diagnostics
from splinebba_cli.project.diagnostics import render_github
from tests.project.project_text import written


def test_a_criterion_points_at_its_line(tmp_path: Path) -> None:
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8") + "\nacceptance:\n  global_test: true\n  max_sigma0: 1.2\n"
    path.write_text(text, encoding="utf-8")
    line = text.splitlines().index("  max_sigma0: 1.2") + 1
    problems = (
        Problem("SBB510", "error", "σ̂₀ 1.5 exceeds 1.2", "acceptance.max_sigma0"),
        Problem("SBB533", "info", "it is weak", "spline `road`", "look"),
    )
    first, second = problem_diagnostics(path, problems)
    assert (first.line, first.column, first.length) == (line, 3, len("max_sigma0"))
    assert second.line is None and second.message == "spline `road`: it is weak"
    lines = render_github((first, second)).splitlines()
    assert lines[0].startswith(f"::error file={path},line={line},col=3,")
    assert lines[1].startswith("::notice ") and lines[1].endswith("%0Ahelp: look")
