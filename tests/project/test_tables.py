"""Tables: delimiters, headers, positions of bad values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.project.diagnostics import SHOWN_PER_KIND, Collector, Place
from splinebba_cli.project.parquet_table import table_from_parquet
from splinebba_cli.project.table import Table
from splinebba_cli.project.tables import TableUnreadableError, table_from_text


def table(text: str, columns: tuple[str, ...] | None = None, **options: object) -> tuple[Table, Collector]:
    collector = Collector()
    read = table_from_text(text, file="t.csv", collector=collector, columns=columns, **options)  # type: ignore[arg-type]
    return read, collector


@pytest.mark.parametrize(
    ("text", "delimiter"),
    [
        ("id,x\n0101,1.5\n", "auto"),
        ("id;x\n0101;1.5\n", "auto"),
        ("id\tx\n0101\t1.5\n", "auto"),
        ("id  x\n  0101   1.5\n", "auto"),
        ('id, x\n"0101",  1.5 \n', "comma"),
        ("# note\n\nid,x\n# more\n0101,1.5\n\n", "auto"),
        ("id,x\r\n0101,1.5\r\n", "auto"),
    ],
)
def test_delimiters_comments_and_headers(text: str, delimiter: str) -> None:
    read, collector = table(text, delimiter=delimiter)
    assert read.texts("id") == ["0101"]
    assert read.numbers("x").tolist() == [1.5]
    assert not collector.items


def test_quoted_fields_may_hold_the_separator() -> None:
    read, collector = table('id,x\n"a,b",1\nc,2\n')
    assert read.texts("id") == ["a,b", "c"]
    assert read.numbers("x").tolist() == [1.0, 2.0]
    assert not collector.items


def test_declared_columns_mean_no_header() -> None:
    read, _ = table("a 1 2\nb 3 4\n", ("id", "-", "x"))
    assert read.texts("id") == ["a", "b"]
    assert read.numbers("x").tolist() == [2.0, 4.0]
    assert not read.has("-")


def test_a_header_may_be_passed_over() -> None:
    read, _ = table("id,x\na,1\n", ("id", "x"), header=True)
    assert read.texts("id") == ["a"]


@pytest.mark.parametrize("bad", ["x", "nan", "inf", "1_0", "", "1,5x"])
def test_bad_number_with_line_and_column(bad: str) -> None:
    read, collector = table(f"id;x\n# note\n\na;1\nb; {bad}\nc;3\n")
    read.numbers("x")
    (found,) = collector.finished()
    assert (found.code, found.file, found.line, found.snippet) == ("SBB403", "t.csv", 5, f"b; {bad}")
    assert found.column == (4 if bad else 3)


def test_empty_numbers_where_they_are_allowed() -> None:
    read, collector = table("id,x\na,\nb,2\nc,-\n")
    np.testing.assert_array_equal(read.numbers("x", optional=True), [np.nan, 2.0, np.nan])
    assert not collector.items


def test_sigmas() -> None:
    read, collector = table("s\n0.5\nfixed\nfree\n-\n")
    np.testing.assert_array_equal(read.sigmas("s"), [0.5, 0.0, np.inf, np.nan])
    assert not collector.items
    read, collector = table("s\n0.5\n0\n-1\nfoo\n")
    read.sigmas("s")
    assert [(d.code, d.line) for d in collector.finished()] == [("SBB309", 3), ("SBB309", 4), ("SBB403", 5)]


def test_whole_numbers() -> None:
    read, collector = table("n,m\n3,1\n,2\n1.5,3\n")
    assert read.integers("n").tolist()[:2] == [3, -1]
    assert [(d.code, d.line) for d in collector.finished()] == [("SBB403", 4)]


def test_empty_ids() -> None:
    read, collector = table("id,x\na,1\n,2\n")
    read.texts("id")
    assert [(d.code, d.line, d.column) for d in collector.finished()] == [("SBB403", 3, 1)]


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("", "SBB405", 1),
        ("# only a note\n", "SBB405", 1),
        ("id,x\n", "SBB405", 1),
        ("id,x\na,1\nb\n", "SBB404", 3),
        ("id,id\na,1\n", "SBB402", 1),
        ('id,x\n"a,1\n', "SBB410", 2),
    ],
)
def test_unreadable_tables(text: str, code: str, line: int) -> None:
    collector = Collector()
    with pytest.raises(TableUnreadableError):
        table_from_text(text, file="t.csv", collector=collector, columns=None)
    assert [(d.code, d.line) for d in collector.finished()] == [(code, line)]


def test_many_bad_rows_are_counted() -> None:
    read, collector = table("x\n" + "bad\n" * (SHOWN_PER_KIND + 30))
    read.numbers("x")
    items = collector.finished()
    assert len(items) == SHOWN_PER_KIND + 1
    assert "30 more" in items[-1].message


def test_a_hundred_thousand_rows() -> None:
    rows = 100_000
    text = "image,spline,x,y\n" + "762,coast-3,1.2345,-67.891\n" * rows
    read, _ = table(text)
    assert len(read.texts("image")) == len(read.texts("spline")) == rows
    assert read.labels("spline").names == ("coast-3",)
    assert read.numbers("x").sum() == pytest.approx(1.2345 * rows)
    assert len(read.numbers("y")) == rows


def test_parquet(tmp_path: Path) -> None:
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "t.parquet"
    parquet.write_table(
        arrow.table({"id": [101, 102], "name": ["0101", "b"], "x": [1.5, float("nan")]}), path
    )
    collector = Collector()
    read = table_from_parquet(
        path.read_bytes(), file="t.parquet", collector=collector, declared_at=Place("p.yaml")
    )
    assert read.texts("id") == ["101", "102"]
    assert read.texts("name") == ["0101", "b"]
    np.testing.assert_array_equal(read.numbers("x", optional=True), [1.5, np.nan])
    assert not collector.items
    read.numbers("x")
    (found,) = collector.finished()
    assert found.code == "SBB403" and "row 2" in found.message and found.line is None
