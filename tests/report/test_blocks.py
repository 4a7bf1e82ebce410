"""What reports are made of."""

from __future__ import annotations

import pytest

from splinebba_cli.report.blocks import Cell, LazyRows


def test_rows_are_made_when_they_are_shown() -> None:
    made: list[int] = []

    def row(number: int) -> tuple[Cell, ...]:
        made.append(number)
        return (number, f"row {number}")

    rows = LazyRows(1000, row)
    assert len(rows) == 1000 and not made
    assert rows[:2] == ((0, "row 0"), (1, "row 1"))
    assert rows[-1] == (999, "row 999")
    assert made == [0, 1, 999]
    assert len(list(LazyRows(3, row))) == 3
    with pytest.raises(IndexError, match="row 1000 of 1000"):
        rows[1000]
