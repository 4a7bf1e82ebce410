"""Tables: units in the headers, values that agree with result.json, the same in CSV and Parquet."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.output.columns import Column, Table, write_table
from splinebba_cli.output.read_table import read_table
from splinebba_cli.output.tables import all_tables
from tests.output.factory import make_result


@pytest.mark.parametrize("fmt", ["csv", "parquet"])
def test_tables_read_back(tmp_path: Path, fmt: str) -> None:
    if fmt == "parquet":
        pytest.importorskip("pyarrow")
    result = make_result()
    for table in all_tables(result):
        write_table(tmp_path, table, fmt)  # type: ignore[arg-type]
    images = read_table(tmp_path, "exterior_orientation")
    np.testing.assert_array_equal(images.numbers("x_m"), result.images.eop[:, 3])
    np.testing.assert_array_equal(images.numbers("phi_deg"), np.degrees(result.images.eop[:, 1]))
    residuals = read_table(tmp_path, "residuals")
    assert residuals.rows == 84
    assert residuals["kind"].count("spline") == 60
    across = residuals.numbers("residual_across_mm")
    assert np.isnan(across[:24]).all()
    np.testing.assert_allclose(across[24:], result.curve_residuals.across, atol=1e-7)
    assert np.isnan(residuals.numbers("standardized_x")[24:]).all()
    assert np.isnan(residuals.numbers("normal_x")[:24]).all()
    priors = read_table(tmp_path, "prior_residuals")
    assert priors["unit"].count("deg") == 1
    assert priors.numbers("sigma")[3] == pytest.approx(np.degrees(0.0005))


def test_every_number_has_its_unit_in_the_header() -> None:
    free_of_unit = ("redundancy", "standardized", "normal", "major_direction", "u", "t", "segment", "rays")
    free_of_unit += ("weight", "round", "row", "statistic", "predicted")
    for table in all_tables(make_result()):
        for column in table.columns:
            if isinstance(column.values, np.ndarray) and table.name != "prior_residuals":
                name = column.name
                assert name.endswith(("_m", "_mm", "_deg", "_sigmas")) or name.startswith(free_of_unit), name


def test_locations_lie_on_their_segments() -> None:
    result = make_result()
    columns = {
        column.name: column.values
        for table in all_tables(result)
        for column in table.columns
        if table.name == "spline_locations"
    }
    u = np.asarray(columns["u"])
    np.testing.assert_array_equal(columns["segment"], np.clip(np.floor(u), 0, 3))
    np.testing.assert_allclose(columns["t"], u - np.floor(u))
    first = result.network.curve_observations.curve == 0
    curve = result.curves[0]
    expected = np.interp(u[first], curve.sample_u, curve.sample_xyz[:, 2])
    np.testing.assert_allclose(np.asarray(columns["z_m"])[first], expected, atol=0.02)


def test_awkward_ids_and_missing_numbers(tmp_path: Path) -> None:
    ids = ["a,b", 'say "x"', "nan", " padded ", "new\nline", ""]
    numbers = np.array([1.0, np.nan, np.inf, -0.0, 1e-300, -2.5])
    table = Table("t", (Column("id", ids), Column("x_m", numbers), Column("y_m", numbers, "%.3f")))
    path = write_table(tmp_path, table, "csv")
    with path.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    assert [row[0] for row in rows[1:]] == ids
    assert [row[1] for row in rows[1:]] == ["1.0", "", "", "0.0", "1e-300", "-2.5"]
    assert [row[2] for row in rows[1:]] == ["1.000", "", "", "0.000", "0.000", "-2.500"]


def test_some_columns_only(tmp_path: Path) -> None:
    for table in all_tables(make_result()):
        write_table(tmp_path, table, "csv")
    assert list(read_table(tmp_path, "residuals", ["image", "kind", "absent"])) == ["kind", "image"]
    assert read_table(tmp_path, "absent").rows == 0
    assert np.isnan(read_table(tmp_path, "points").numbers("absent")).all()


def test_no_features(tmp_path: Path) -> None:
    for table in all_tables(make_result(splines=0, points=0)):
        path = write_table(tmp_path, table, "csv")
        assert path.read_text(encoding="utf-8").count("\n") == len(table) + 1
        assert read_table(tmp_path, table.name).rows == len(table)
