"""A result folder read back as arrays: orientations, points, curves, their dispersions, what was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.polynomial import polynomial_basis
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray, RotationSequence
from splinebba_cli.core.quality.curve_comparison import SampledCurve
from splinebba_cli.core.quality.variance_comparison import SumOfSquares
from splinebba_cli.output.read_table import read_table
from splinebba_cli.output.result_json import load_result_json
from splinebba_cli.output.segments_table import with_segments

_ANGLES, _XYZ = ("omega", "phi", "kappa"), ("x", "y", "z")
_POWERS = 4
_MEASURED = ("kind", "image", "feature", "measured_x_mm", "measured_y_mm")
_OUT = ("rejected", "excluded by user")  # status of what takes no part
Observation = tuple[str, ...]


@dataclass(frozen=True)
class StoredResult:
    """What a comparison needs of a result folder; metres, radians, user's object frame."""

    folder: Path
    content: dict[str, Any]
    image_dispersion: FloatArray  # (m, 6, 6) omega, phi, kappa, X0, Y0, Z0
    point_dispersion: FloatArray  # (n, 3, 3), NaN of points that nothing locates
    correlated: bool  # whether the dispersions hold covariances (dispersion.npz), not variances alone
    full_images: FloatArray | None = None  # (6 m, 6 m) all orientations together, of `--dispersion full`

    @cached_property
    def image_ids(self) -> list[str]:
        """Ids of the images."""
        return [image["id"] for image in self.content["images"]]

    @cached_property
    def sequences(self) -> list[RotationSequence]:
        """Rotation sequences of the images."""
        return [image.get("rotation_sequence", "omega-phi-kappa") for image in self.content["images"]]

    @cached_property
    def angles(self) -> FloatArray:
        """omega, phi, kappa, (m, 3) rad."""
        return np.radians(_numbers(self.content["images"], _ANGLES))

    @cached_property
    def position(self) -> FloatArray:
        """Perspective centres, (m, 3) m."""
        return _numbers(self.content["images"], _XYZ)

    @cached_property
    def rotation(self) -> FloatArray:
        """Rotations object from photo, (m, 3, 3)."""
        pairs = zip(self.angles, self.sequences, strict=True)
        found = [rotation_object_from_photo(angles, sequence) for angles, sequence in pairs]
        return np.array(found).reshape(-1, 3, 3)

    @cached_property
    def point_ids(self) -> list[str]:
        """Ids of the points."""
        return [point["id"] for point in self.content["points"]]

    @cached_property
    def xyz(self) -> FloatArray:
        """Points, (n, 3) m."""
        return _numbers(self.content["points"], _XYZ)

    @property
    def sum_of_squares(self) -> SumOfSquares:
        """v'Pv with its redundancy."""
        statistics = self.content["statistics"]
        vtpv = float(statistics["vtpv"]) / float(statistics["sigma0_prior"]) ** 2
        return SumOfSquares(vtpv, float(statistics["redundancy"]))

    @property
    def estimated_variance(self) -> bool:
        """Whether the dispersions are multiplied by the estimated variance of unit weight."""
        return (
            bool(self.content["settings"]["sigmas_scaled_by_sigma0"]) and self.sum_of_squares.redundancy >= 1
        )

    @property
    def scale(self) -> float:
        """Variance factor of the dispersions."""
        return self.sum_of_squares.variance if self.estimated_variance else 1.0

    @property
    def free(self) -> bool:
        """Whether the datum is not that of control and priors, which leave something undetermined."""
        defect = int(self.content["statistics"]["rank_defect"])
        return defect > 0 and str(self.content["settings"]["datum"]) != "control"

    @cached_property
    def measured(self) -> frozenset[Observation]:
        """Image points that take part: kind, image, feature, x, y as they are written."""
        table = read_table(self.folder, "residuals", (*_MEASURED, "status"))
        if not table.rows:
            return frozenset()
        status = table["status"] if "status" in table else [""] * table.rows
        rows = zip(*(table[name] for name in _MEASURED), strict=True)
        return frozenset(row for row, how in zip(rows, status, strict=True) if how not in _OUT)

    def curves(self, origin: FloatArray) -> dict[str, SampledCurve]:
        """Adjusted curves by id, positions less `origin`; those without samples or shape are left out."""
        table = read_table(self.folder, "spline_samples")
        if not table.rows:
            return {}
        rows_of: dict[str, list[int]] = {}
        for row, name in enumerate(table["spline"]):
            rows_of.setdefault(name, []).append(row)
        columns = {name: table.numbers(name) for name in table if name != "spline"}
        found = {}
        for spline in self.content["splines"]:
            rows = np.array(rows_of.get(spline["id"], []), dtype=np.int64)
            shape = curve_function(spline, origin)
            if not len(rows) or shape is None or not shape[0].has_location:
                continue
            found[spline["id"]] = SampledCurve(
                name=spline["id"],
                basis=shape[0],
                coefficients=shape[1],
                u=columns["u"][rows],
                xyz=_stacked(columns, ("x_m", "y_m", "z_m"), rows) - origin,
                across=_stacked(columns, ("sigma_across_major_m", "sigma_across_minor_m"), rows),
                direction=_stacked(columns, tuple(f"major_direction_{axis}" for axis in _XYZ), rows),
            )
        return found


def read_result(folder: Path) -> StoredResult:
    """Read a result folder.

    Raises
    ------
    OutputError
        SBB602 if it is none.
    """
    content = load_result_json(folder)
    folder = folder if folder.is_dir() else folder.parent
    content = with_segments(content, folder)
    path = folder / "dispersion.npz"
    if path.exists():
        with np.load(path, allow_pickle=False) as file:
            factor = np.where(np.arange(6) < 3, np.pi / 180.0, 1.0)
            images = file["image_dispersion"] * np.outer(factor, factor)
            full, count = None, 6 * len(images)
            if "matrix" in file:
                scale = np.tile(factor, len(images))
                full = file["matrix"][:count, :count] * np.outer(scale, scale)
            return StoredResult(folder, content, images, file["point_dispersion"], True, full)
    sigma = np.radians(_numbers([i["sigma"] for i in content["images"]], _ANGLES))
    both = np.hstack([sigma, _numbers([i["sigma"] for i in content["images"]], _XYZ)])
    points = _numbers([p["sigma"] for p in content["points"]], _XYZ)
    return StoredResult(folder, content, _diagonal(np.nan_to_num(both)), _diagonal(points), False)


def curve_function(spline: dict[str, Any], origin: FloatArray) -> tuple[CurveBasis, FloatArray] | None:
    """Basis and coefficients of a curve of result.json, positions less `origin`; None if it is not described.

    Curves with segments are taken as cubics of every segment; trigonometric ones by the rows of their family.
    """
    segments = spline["segments"]
    if segments:
        breaks = [segments[0]["interval"][0], *(segment["interval"][1] for segment in segments)]
        rows = np.array([[segment[letter] for letter in "abc"] for segment in segments], dtype=float)
        rows = rows.transpose(0, 2, 1).copy()  # (s, powers, 3)
        rows[:, 0] -= origin
        padded = np.zeros((len(rows), _POWERS, 3))
        padded[:, : rows.shape[1]] = rows
        basis = replace(polynomial_basis(_POWERS - 1, np.array(breaks, dtype=float)), closed=spline["closed"])
        return basis, padded.reshape(-1, 3)
    if "values" not in spline:
        return None
    values = np.array(spline["values"], dtype=float)
    knots = spline.get("knot_parameters")
    arc = None if spline["closed"] or not knots else np.array([knots[0], knots[-1]])
    curve = Curve(
        spline["id"], spline["role"], spline["family"], values, np.zeros_like(values), spline["closed"], arc
    )
    basis = basis_of(curve)
    shift = np.where(basis.value_is_position[:, None], origin, 0.0)
    return basis, basis.coefficients_from_values(values - shift)


def _numbers(rows: list[dict[str, Any]], keys: tuple[str, ...]) -> FloatArray:
    found = [[np.nan if row[key] is None else row[key] for key in keys] for row in rows]
    return np.array(found, dtype=float).reshape(-1, len(keys))


def _stacked(columns: dict[str, FloatArray], names: tuple[str, ...], rows: Any) -> FloatArray:
    return np.stack([columns[name][rows] for name in names], axis=1)


def _diagonal(sigma: FloatArray) -> FloatArray:
    return np.asarray(sigma[:, :, None] ** 2 * np.eye(sigma.shape[1]))
