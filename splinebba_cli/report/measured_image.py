"""The measurements of one image with their residuals, as a figure needs them.

Vectors are v = adjusted − measured: both components for points, the part across the curve for points on splines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.output.read_table import ReadTable
from splinebba_cli.report.result_data import ResultData, rows_of


@dataclass(frozen=True)
class MeasuredPoints:
    """Image points of all images, row by row of residuals.csv."""

    on_spline: BoolArray  # (n,)
    xy: FloatArray  # (n, 2) mm
    vector: FloatArray  # (n, 2) mm
    w: FloatArray  # (n,) largest |standardized residual|, NaN where not tested
    out: BoolArray  # (n,) rejected or excluded
    rows: dict[str, IntArray]  # of every image

    @classmethod
    def of(cls, data: ResultData) -> MeasuredPoints:
        """All image points of a result."""
        table = data.image_points
        on_spline = np.array([kind == "spline" for kind in table["kind"]], dtype=bool)
        across, normal = table.numbers("residual_across_mm"), _pair(table, "normal_{}")
        residual = _pair(table, "residual_{}_mm")
        vector = np.where(on_spline[:, None], across[:, None] * normal, residual)
        w = np.stack([np.abs(table.numbers(f"standardized_{name}")) for name in ("x", "y", "across")])
        largest = np.where(np.isnan(w).all(axis=0), np.nan, np.nan_to_num(w).max(axis=0))
        return cls(
            on_spline,
            _pair(table, "measured_{}_mm"),
            vector,
            largest,
            ~data.taking_part,
            rows_of(table["image"]),
        )

    def rms_mm(self, image: str) -> float:
        """Root mean square of the tested components of one image; 0 where there are none."""
        rows = self.rows[image]
        rows = rows[~self.out[rows]]
        squares = np.nansum(self.vector[rows] ** 2)
        count = np.sum(np.where(self.on_spline[rows], 1, 2))
        return float(np.sqrt(squares / count)) if count else 0.0

    def worst_first(self) -> Iterator[str]:
        """Images by the root mean square of their residuals."""
        rms = {image: self.rms_mm(image) for image in self.rows}
        return iter(sorted(rms, key=lambda image: -rms[image]))


def _pair(table: ReadTable, name: str) -> FloatArray:
    return np.stack([table.numbers(name.format(axis)) for axis in "xy"], axis=1)
