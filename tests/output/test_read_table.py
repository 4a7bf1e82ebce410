"""A table in memory reads as the file does; segments that stand in their table come back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from splinebba_cli.output import result_json
from splinebba_cli.output.columns import TableFormat, write_table
from splinebba_cli.output.read_table import as_read, read_table
from splinebba_cli.output.segments_table import with_segments
from splinebba_cli.output.tables import all_tables, spline_coefficients_table
from tests.output.factory import make_result


def test_in_memory_as_in_the_file(tmp_path: Path) -> None:
    for table in all_tables(make_result()):
        write_table(tmp_path, table, "csv")
        stored, ours = read_table(tmp_path, table.name), as_read(table)
        assert list(ours) == list(stored) and ours.rows == stored.rows
        for column in table.columns:
            assert list(ours[column.name]) == list(stored[column.name]), column.name
            if isinstance(column.values, np.ndarray):
                np.testing.assert_array_equal(ours.numbers(column.name), stored.numbers(column.name))


def test_some_rows_of_both(tmp_path: Path) -> None:
    (table,) = [t for t in all_tables(make_result()) if t.name == "residuals"]
    write_table(tmp_path, table, "csv")
    stored, ours = (
        one.where("kind", lambda kind: kind == "spline")
        for one in (read_table(tmp_path, table.name), as_read(table))
    )
    assert ours.rows == stored.rows < len(table)
    for name in ("feature", "residual_across_mm", "weight"):
        assert list(ours[name]) == list(stored[name])


@pytest.mark.parametrize("fmt", ["csv", "parquet"])
def test_many_segments_stand_in_their_table(
    fmt: TableFormat, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = make_result()
    whole: dict[str, Any] = result_json.result_to_dict(result)
    monkeypatch.setattr(result_json, "MOST_SEGMENTS", 1)
    short = result_json.result_to_dict(result)
    assert all(spline["segments"] == [] for spline in short["splines"])
    write_table(tmp_path, spline_coefficients_table(result), fmt)
    assert with_segments(short, tmp_path)["splines"] == whole["splines"]
    assert with_segments(whole, tmp_path) is whole
