"""What a report is made from: result.json and, when they are needed, the tables beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.output.read_table import ReadTable, as_read, read_table
from splinebba_cli.output.result_folder import Written
from splinebba_cli.output.result_json import load_result_json

Tables = Callable[[str, tuple[str, ...] | None], ReadTable]

_RESIDUAL_COLUMNS = (
    "kind",
    "image",
    "feature",
    "residual_x_mm",
    "residual_y_mm",
    "residual_across_mm",
    "standardized_x",
    "standardized_y",
    "standardized_across",
    "status",
)
_OUT = ("rejected", "excluded by user")


@dataclass(frozen=True)
class SplineSamples:
    """Points along one spline with the standard ellipse across it."""

    u: FloatArray  # (n,)
    xyz: FloatArray  # (n, 3) m
    across: FloatArray  # (n, 2) semi-axes, m, larger first
    direction: FloatArray  # (n, 3) of the larger semi-axis


class ResultData:
    """The data of a result folder; without tables (console summary) they are empty.

    Parameters
    ----------
    content : dict
        Content of result.json.
    tables : callable, optional
        Gives the table of a name, some of its columns or (None) all.
    """

    def __init__(self, content: dict[str, Any], tables: Tables | None = None) -> None:
        self.content = content
        self._tables = tables

    @classmethod
    def load(cls, folder: Path) -> ResultData:
        """Read a result folder; OutputError SBB602 if it is none."""
        return cls(load_result_json(folder), lambda name, columns: read_table(folder, name, columns))

    @classmethod
    def of(cls, written: Written) -> ResultData:
        """What was just written, as it would be read back."""
        tables = {table.name: table for table in written.tables}

        def table_of(name: str, columns: tuple[str, ...] | None) -> ReadTable:
            return as_read(tables[name], columns) if name in tables else ReadTable({})

        return cls(written.content, table_of)

    def __getitem__(self, key: str) -> Any:
        return self.content[key]

    @cached_property
    def residuals(self) -> ReadTable:
        """Residuals of the image points that take part: the columns that the report needs."""
        table = self._read("residuals", _RESIDUAL_COLUMNS)
        return table.where("status", lambda status: status not in _OUT)

    @cached_property
    def priors(self) -> ReadTable:
        """Residuals of control, priors and conditions."""
        return self._read("prior_residuals")

    @cached_property
    def samples_by_spline(self) -> dict[str, SplineSamples]:
        """Points along every spline, by its id."""
        table = self._read("spline_samples")
        if not table.rows:
            return {}
        u = table.numbers("u")
        xyz = np.stack([table.numbers(f"{axis}_m") for axis in "xyz"], axis=1)
        across = np.stack([table.numbers(f"sigma_across_{axis}_m") for axis in ("major", "minor")], axis=1)
        direction = np.stack([table.numbers(f"major_direction_{axis}") for axis in "xyz"], axis=1)
        rows: dict[str, list[int]] = {}
        for row, name in enumerate(table["spline"]):
            rows.setdefault(name, []).append(row)
        return {name: SplineSamples(u[i], xyz[i], across[i], direction[i]) for name, i in rows.items()}

    @cached_property
    def ellipses(self) -> ReadTable:
        """Error ellipses of images and points."""
        return self._read("error_ellipses", ("kind", "id", "semi_major_m", "semi_minor_m", "azimuth_deg"))

    def _read(self, name: str, columns: tuple[str, ...] | None = None) -> ReadTable:
        return ReadTable({}) if self._tables is None else self._tables(name, columns)
