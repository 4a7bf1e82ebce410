"""Rows of long tables as data of the page: what is shown, and nothing that ends the script element."""

from __future__ import annotations

import json
from typing import Any

import pytest

from splinebba_cli.report.blocks import Cell, Column, LazyRows, Table, cell_text
from splinebba_cli.report.table_payload import table_payload


def _column(column: Column, *cells: Cell) -> Any:
    table = Table("t", (column,), [(cell,) for cell in cells])
    return json.loads(table_payload(table, 1000))["columns"][0]


@pytest.mark.parametrize(
    "value", [0.0, -0.0004, 1.25, -1.005, 1e-9, 123456.7895, 2.5, 100.0, -0.5, 1e15 + 0.5]
)
@pytest.mark.parametrize("decimals", [0, 1, 3, 6])
def test_rounded_as_it_is_shown(value: float, decimals: int) -> None:
    column = Column("x", "m", decimals)
    (kept,) = _column(column, value)
    assert f"{kept:.{decimals}f}" == cell_text(column, value)


def test_numbers_without_value_and_without_end() -> None:
    assert _column(Column("x", "m", 2), 1.0, None, float("inf"), "text") == [1, None, "inf", "text"]
    assert _column(Column("n"), 12, 0.5, 1e-7, None) == [12, 0.5, 1e-7, None]


def test_every_word_once() -> None:
    found = _column(Column("id", numeric=False), "b", "a", "b", None)
    assert found == {"words": ["b", "a"], "at": [0, 1, 0, None]}


def test_safe_in_a_script_element() -> None:
    evil = "</script><!--<script>&\u2028"
    text = table_payload(Table("t", (Column("id", numeric=False),), [(evil,)]), 10)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text)["columns"][0]["words"] == [evil]


def test_no_more_rows_than_wanted_are_made() -> None:
    made: list[int] = []

    def row(number: int) -> tuple[Cell, ...]:
        made.append(number)
        return (number,)

    table = Table("t", (Column("n"),), LazyRows(10**6, row), frozenset({2, 5, 999_999}))
    content = json.loads(table_payload(table, 4))
    assert content == {"columns": [[0, 1, 2, 3]], "marked": [2]}
    assert made == [0, 1, 2, 3]
