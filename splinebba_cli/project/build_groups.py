"""What groups of scalar observations share: a σ of the group or of a column, and the number of the group."""

from __future__ import annotations

from collections.abc import Sequence, Sized

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.table import Table
from splinebba_cli.project.yaml_source import YamlPath


def group_numbers(parts: Sequence[tuple[Sized, ...]]) -> IntArray:
    """Number of the group of every observation, groups one after another."""
    return np.concatenate([np.full(len(part[0]), k, dtype=np.int64) for k, part in enumerate(parts)])


def sigma_column(
    value: float | None, table: Table, column: str, path: YamlPath, building: Building
) -> FloatArray:
    """σ of the group, or of its column where there is one, (n,)."""
    sigma = np.full(table.rows, np.nan if value is None else value)
    if table.has(column):
        own = table.sigmas(column)
        for row in np.flatnonzero((own == 0.0) | np.isinf(own))[:1]:
            building.collector.error(
                "SBB309", f"`{column}` must be a number", table.place_of(int(row), column)
            )
        sigma = np.where(np.isnan(own), sigma, own)
    for row in np.flatnonzero(np.isnan(sigma))[:1]:
        place = table.place_of(int(row), column) if table.has(column) else building.source.place(path)
        building.collector.error(
            "SBB202", "a measurement without σ", place, f"`{column}` of the group or column"
        )
    return np.where(np.isfinite(sigma) & (sigma > 0.0), sigma, 1.0)
