"""Diagnostics and their renderers."""

from __future__ import annotations

import json

from splinebba_cli.errors import ProjectError
from splinebba_cli.project.diagnostics import (
    SHOWN_PER_KIND,
    Collector,
    Place,
    render_github,
    render_json,
    render_text,
    suggestion,
)

PLACE = Place("p.yaml", 12, 5, 3, "  - foo: 1")


def one() -> Collector:
    collector = Collector()
    collector.error("SBB201", "unknown key `foo`", PLACE, "did you mean `for`?")
    return collector


def test_text_with_snippet_and_caret() -> None:
    assert render_text(one().finished()) == (
        "error[SBB201]: unknown key `foo`\n"
        "  --> p.yaml:12:5\n"
        "   |\n"
        "12 |   - foo: 1\n"
        "   |     ^^^\n"
        "   = help: did you mean `for`?"
    )


def test_caret_of_a_long_line_stays_below_its_word() -> None:
    line = "x" * 300 + "BAD" + "y" * 300
    collector = Collector()
    collector.error("SBB403", "bad", Place("t.csv", 1, 301, 3, line))
    snippet, caret = render_text(collector.finished()).splitlines()[3:5]
    assert snippet[caret.index("^") : caret.rindex("^") + 1] == "BAD"
    assert len(snippet) < 120


def test_json_and_github() -> None:
    (item,) = json.loads(render_json(one().finished()))
    assert item == {
        "code": "SBB201",
        "severity": "error",
        "message": "unknown key `foo`",
        "help": "did you mean `for`?",
        "file": "p.yaml",
        "line": 12,
        "column": 5,
        "length": 3,
    }
    assert render_github(one().finished()) == (
        "::error file=p.yaml,line=12,col=5,endColumn=8,title=SBB201::"
        "unknown key `foo`%0Ahelp: did you mean `for`?"
    )


def test_many_of_a_kind_are_counted() -> None:
    collector = Collector()
    for row in range(SHOWN_PER_KIND + 7):
        collector.error("SBB403", "bad", Place("t.csv", row + 1), kind="bad values")
    items = collector.finished()
    assert len(items) == SHOWN_PER_KIND + 1
    assert items[-1].message == "… and 7 more: bad values"


def test_order_is_that_of_the_files() -> None:
    collector = Collector()
    for file, line in (("a", 9), ("b", 1), ("a", 2)):
        collector.warning("SBB305", "x", Place(file, line))
    assert [(d.file, d.line) for d in collector.finished()] == [("a", 2), ("a", 9), ("b", 1)]
    assert not collector.has_errors


def test_an_error_of_a_project_tells_how_many_there_are() -> None:
    collector = one()
    collector.error("SBB203", "second", PLACE)
    error = ProjectError(collector.finished())
    assert len(error.diagnostics) == 2
    assert "1 more" in str(error)
    assert error.exit_code == 2


def test_suggestion() -> None:
    assert suggestion("rolle", ["role", "id"]) == "did you mean `role`?"
    assert suggestion("xyzzy", ["role", "id"]) == ""
