"""What a report is made from: result.json and, when they are needed, the tables beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.output.dispersion_file import read_dispersion
from splinebba_cli.output.read_table import ReadTable, as_read, read_table
from splinebba_cli.output.result_folder import Written
from splinebba_cli.output.result_json import load_result_json

Tables = Callable[[str, tuple[str, ...] | None], ReadTable]
Dispersion = Callable[[], Mapping[str, NDArray[Any]]]

_RESIDUAL_COLUMNS = (
    "kind",
    "image",
    "feature",
    "measured_x_mm",
    "measured_y_mm",
    "residual_x_mm",
    "residual_y_mm",
    "residual_across_mm",
    "redundancy_x",
    "redundancy_y",
    "redundancy_across",
    "standardized_x",
    "standardized_y",
    "standardized_across",
    "minimal_detectable_bias_x_mm",
    "minimal_detectable_bias_y_mm",
    "minimal_detectable_bias_across_mm",
    "normal_x",
    "normal_y",
    "status",
)
_ELLIPSE_COLUMNS = (
    "kind",
    "id",
    *(f"ellipsoid_{k}_{part}" for k in (1, 2, 3) for part in ("m", "x", "y", "z")),
)
OUT = ("rejected", "excluded by user")


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
    dispersion : callable, optional
        Gives the arrays of dispersion.npz, none where it was not written.
    """

    def __init__(
        self, content: dict[str, Any], tables: Tables | None = None, dispersion: Dispersion | None = None
    ) -> None:
        self.content = content
        self._tables = tables
        self._dispersion = dispersion

    @classmethod
    def load(cls, folder: Path) -> ResultData:
        """Read a result folder; OutputError SBB602 if it is none."""
        return cls(
            load_result_json(folder),
            lambda name, columns: read_table(folder, name, columns),
            lambda: read_dispersion(folder / "dispersion.npz"),
        )

    @classmethod
    def of(cls, written: Written) -> ResultData:
        """What was just written, as it would be read back."""
        tables = {table.name: table for table in written.tables}

        def table_of(name: str, columns: tuple[str, ...] | None) -> ReadTable:
            return as_read(tables[name], columns) if name in tables else ReadTable({})

        return cls(written.content, table_of, lambda: written.dispersion)

    def __getitem__(self, key: str) -> Any:
        return self.content[key]

    @cached_property
    def image_points(self) -> ReadTable:
        """All image points with residuals, also those that are out: the columns that the report needs."""
        return self._read("residuals", _RESIDUAL_COLUMNS)

    @cached_property
    def residuals(self) -> ReadTable:
        """Image points that take part."""
        return self.image_points.where("status", lambda status: status not in OUT)

    @cached_property
    def taking_part(self) -> BoolArray:
        """Which image points take part, (n,)."""
        table = self.image_points
        if "status" not in table:
            return np.ones(table.rows, dtype=bool)
        return np.array([status not in OUT for status in table["status"]], dtype=bool)

    @cached_property
    def locations(self) -> ReadTable:
        """Where along its spline, and in the object, every image point on a spline lies."""
        return self._read("spline_locations", ("image", "spline", "u", "x_m", "y_m", "z_m"))

    @cached_property
    def locations_by_spline(self) -> dict[str, dict[str, FloatArray]]:
        """Locations u of the measured points of every spline, image by image in the order of the images."""
        table = self.locations
        if not table.rows:
            return {}
        u, images = table.numbers("u"), list(table["image"])
        order = {image["id"]: number for number, image in enumerate(self["images"])}
        found: dict[str, dict[str, FloatArray]] = {}
        for spline, rows in rows_of(table["spline"]).items():
            own = rows_of([images[row] for row in rows])
            found[spline] = {
                image: u[rows[own[image]]] for image in sorted(own, key=lambda i: order.get(i, -1))
            }
        return found

    @cached_property
    def redundancy_along(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Locations u and redundancy numbers across of the image points of every spline; NaN where one is out."""
        table, locations = self.image_points, self.locations
        on_spline = np.array([kind == "spline" for kind in table.get("kind", ())], dtype=bool)
        if not locations.rows or on_spline.sum() != locations.rows:
            return {}
        r = np.where(self.taking_part, table.numbers("redundancy_across"), np.nan)[on_spline]
        u = locations.numbers("u")
        return {name: (u[rows], r[rows]) for name, rows in rows_of(locations["spline"]).items()}

    @cached_property
    def dispersion(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of dispersion.npz; empty where there is none."""
        return {} if self._dispersion is None else self._dispersion()

    @cached_property
    def spline_residuals(self) -> dict[str, dict[str, Any]]:
        """Summary of the residuals of every spline, by its id."""
        return {summary["id"]: summary for summary in self["residuals"]["splines"]}

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
        return {
            name: SplineSamples(u[i], xyz[i], across[i], direction[i])
            for name, i in rows_of(table["spline"]).items()
        }

    @cached_property
    def ellipses(self) -> ReadTable:
        """Error ellipsoids of images and points."""
        return self._read("error_ellipses", _ELLIPSE_COLUMNS)

    def _read(self, name: str, columns: tuple[str, ...] | None = None) -> ReadTable:
        return ReadTable({}) if self._tables is None else self._tables(name, columns)


def rows_of(names: Sequence[str]) -> dict[str, IntArray]:
    """Numbers of the rows of every name, names in the order of their alphabet."""
    found, number = np.unique(np.array(list(names), dtype=object), return_inverse=True)
    order = np.argsort(number, kind="stable")
    ends = np.searchsorted(number[order], np.arange(len(found) + 1))
    return {str(name): order[ends[i] : ends[i + 1]] for i, name in enumerate(found)}
