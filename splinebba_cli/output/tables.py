"""The tables of a result folder: one function a table, units in the column names.

Metres in the user's object frame, millimetres in the measured photo frame, degrees.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult, ScalarResiduals
from splinebba_cli.output.columns import Column, Table
from splinebba_cli.output.ellipse_table import error_ellipse_tables
from splinebba_cli.output.located import places_on_splines
from splinebba_cli.output.model_evidence_tables import model_evidence_tables
from splinebba_cli.output.revision_tables import rejections_tables, revision_columns
from splinebba_cli.project.labels import Labels

_PHOTO = "%.7f"  # mm: a tenth of a nanometre
_RATIO = "%.6f"
_ANGLE = "%.7f"  # degrees
ANGLES = ("omega", "phi", "kappa")
EOP_NAMES = ("omega", "phi", "kappa", "X0", "Y0", "Z0")


def all_tables(result: AdjustmentResult) -> tuple[Table, ...]:
    """Every table of the result folder, in the order of writing; arc lengths and tangents where there are any."""
    return (
        exterior_orientation_table(result),
        points_table(result),
        *error_ellipse_tables(result.evidence.precision),
        spline_coefficients_table(result),
        spline_samples_table(result),
        spline_locations_table(result),
        residuals_table(result),
        *linked_residuals_tables(result),
        prior_residuals_table(result),
        *model_evidence_tables(result),
        *rejections_tables(result),
    )


def exterior_orientation_table(result: AdjustmentResult) -> Table:
    """One row an image: perspective centre in metres, angles in degrees, their standard deviations."""
    images = result.images
    sigma = np.sqrt(np.maximum(np.einsum("mii->mi", images.dispersion), 0.0))
    eop = images.eop
    columns = [
        Column("image", result.network.images.ids),
        Column("camera", Labels([c.id for c in result.network.cameras], result.network.images.camera)),
        Column("rotation_sequence", result.network.images.sequence),
    ]
    columns += [Column(f"{name}_m", eop[:, 3 + i]) for i, name in enumerate("xyz")]
    columns += [Column(f"{name}_deg", np.degrees(eop[:, i])) for i, name in enumerate(ANGLES)]
    columns += [Column(f"sigma_{name}_m", sigma[:, 3 + i]) for i, name in enumerate("xyz")]
    columns += [Column(f"sigma_{name}_deg", np.degrees(sigma[:, i])) for i, name in enumerate(ANGLES)]
    return Table("exterior_orientation", tuple(columns))


def points_table(result: AdjustmentResult) -> Table:
    """One row an object point: coordinates, standard deviations, number of rays."""
    points = result.points
    sigma = np.sqrt(np.maximum(np.einsum("nii->ni", points.dispersion), 0.0))
    columns = [Column("point", result.network.points.ids), Column("role", result.network.points.role)]
    columns += [Column(f"{name}_m", points.xyz[:, i]) for i, name in enumerate("xyz")]
    columns += [Column(f"sigma_{name}_m", sigma[:, i]) for i, name in enumerate("xyz")]
    columns.append(Column("rays", points.rays))
    return Table("points", tuple(columns))


def spline_coefficients_table(result: AdjustmentResult) -> Table:
    """One row a segment: X = a0 + a1 t + a2 t² + a3 t³, Y with b, Z with c; t in [0, 1] over the interval."""
    curves = CurveColumns.of(result.curves)
    counts, segments = curves.segment_counts, curves.power_segments
    interval = segments.interval
    columns = [
        Column("spline", Labels(_curve_ids(result), np.repeat(np.arange(len(counts)), counts))),
        Column("segment", np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)),
        Column("u_start", interval[:, 0]),
        Column("u_end", interval[:, 1]),
    ]
    for prefix, values in (("", segments.coefficients), ("sigma_", segments.sigma)):
        for axis, letter in enumerate("abc"):
            columns += [Column(f"{prefix}{letter}{power}_m", values[:, power, axis]) for power in range(4)]
    return Table("spline_coefficients", tuple(columns))


def spline_samples_table(result: AdjustmentResult) -> Table:
    """Points along every spline with the standard ellipse across it: for plots of precision."""
    curves = CurveColumns.of(result.curves)
    xyz, across, direction = curves.sample_xyz, curves.sample_across, curves.sample_across_direction
    counts = np.diff(curves.sample_bounds)
    columns = [
        Column("spline", Labels(_curve_ids(result), np.repeat(np.arange(len(counts)), counts))),
        Column("u", curves.sample_u, "%.9g"),
    ]
    columns += [Column(f"{name}_m", xyz[:, i], "%.6f") for i, name in enumerate("xyz")]
    columns += [
        Column("sigma_across_major_m", across[:, 0], "%.6g"),
        Column("sigma_across_minor_m", across[:, 1], "%.6g"),
    ]
    columns += [Column(f"major_direction_{name}", direction[:, i], _RATIO) for i, name in enumerate("xyz")]
    return Table("spline_samples", tuple(columns))


def spline_locations_table(result: AdjustmentResult) -> Table:
    """One row an image point on a spline: its location u, segment, t in [0, 1], place in the object."""
    observations = result.network.curve_observations
    location = result.curve_residuals.location
    segment, t, xyz = places_on_splines(result)
    columns = [
        Column("image", Labels(result.network.images.ids, observations.image)),
        Column("spline", Labels(_curve_ids(result), observations.curve)),
        Column("measured_x_mm", observations.photo_xy[:, 0], _PHOTO),
        Column("measured_y_mm", observations.photo_xy[:, 1], _PHOTO),
        Column("u", location, "%.9g"),
        Column("segment", segment),
        Column("u_sigma_datum_dependent", result.curve_residuals.location_sigma, "%.6g"),
        Column("t", t, "%.9f"),
    ]
    columns += [Column(f"{name}_m", xyz[:, i], "%.6f") for i, name in enumerate("xyz")]
    return Table("spline_locations", tuple(columns))


def residuals_table(result: AdjustmentResult) -> Table:
    """One row an image point, points first: v = adjusted - measured; splines are tested across only."""
    network = result.network
    points, curves = network.point_observations, network.curve_observations
    n = len(points)
    features = Labels.joined(
        Labels(network.points.ids, points.point), Labels(_curve_ids(result), curves.curve)
    )
    images = Labels(network.images.ids, np.concatenate([points.image, curves.image]))
    both = (result.point_residuals, result.curve_residuals)
    redundancy = np.concatenate([both[0].redundancy, both[1].redundancy])
    standardized = np.concatenate([both[0].standardized, both[1].standardized])
    residual = np.concatenate([both[0].residual, both[1].residual])
    normal = np.concatenate([both[0].normal, both[1].normal])
    measured = np.concatenate([points.photo_xy, curves.photo_xy])
    sigma = np.concatenate([points.sigma, curves.sigma])
    columns = [
        Column("kind", Labels(("point", "spline"), np.repeat([0, 1], [n, len(curves)]))),
        Column("image", images),
        Column("feature", features),
    ]
    for name, values in (("measured", measured), ("sigma", sigma), ("residual", residual)):
        columns += [Column(f"{name}_{axis}_mm", values[:, i], _PHOTO) for i, axis in enumerate("xy")]
    across = np.concatenate([np.full(n, np.nan), both[1].across])
    columns.append(Column("residual_across_mm", across, _PHOTO))
    for name, values in (("redundancy", redundancy), ("standardized", standardized)):
        columns += [
            Column(f"{name}_{axis}", _only(values[:, i], slice(n)), _RATIO) for i, axis in enumerate("xy")
        ]
        columns.append(Column(f"{name}_across", _only(values[:, 0], slice(n, None)), _RATIO))
    columns += _reliability_columns(result)
    columns += [Column(f"normal_{axis}", normal[:, i], _RATIO) for i, axis in enumerate("xy")]
    columns += revision_columns(result, "point", "spline")
    return Table("residuals", tuple(columns))


def _reliability_columns(result: AdjustmentResult) -> list[Column]:
    """Minimal detectable bias, and its largest effect on the orientation of the image in sigmas."""
    both, n = (
        (result.point_residuals.reliability, result.curve_residuals.reliability),
        len(result.point_residuals.across),
    )
    columns = []
    for name, unit, decimals, values in (
        ("minimal_detectable_bias", "_mm", _PHOTO, [one.minimal_detectable_bias for one in both]),
        ("orientation_influence", "_sigmas", "%.4f", [one.orientation_influence for one in both]),
    ):
        stacked = np.concatenate(values)
        columns += [
            Column(f"{name}_{axis}{unit}", _only(stacked[:, i], slice(n)), decimals)
            for i, axis in enumerate("xy")
        ]
        columns.append(Column(f"{name}_across{unit}", _only(stacked[:, 0], slice(n, None)), decimals))
    return columns


def linked_residuals_tables(result: AdjustmentResult) -> tuple[Table, ...]:
    """One row an arc length (mm) and one row a tangent (degrees), v = adjusted - measured, in the photo frame."""
    network = result.network
    arcs, tangents = network.arc_lengths, network.tangents
    found = []
    if len(arcs):
        columns = [
            *_seen_columns(result, arcs.first),
            *_location_columns(result, ("from", arcs.first), ("to", arcs.second)),
        ]
        columns += [Column("measured_mm", arcs.length, _PHOTO), Column("sigma_mm", arcs.sigma, _PHOTO)]
        columns += _scalar_columns(result.arc_residuals, "mm", 1.0, _PHOTO)
        columns += revision_columns(result, "arc length")
        columns.append(Column("method", ["simpson" if s else "gauss-legendre" for s in arcs.simpson]))
        found.append(Table("arc_residuals", tuple(columns)))
    if len(tangents):
        factor = 180.0 / np.pi
        columns = [*_seen_columns(result, tangents.point), *_location_columns(result, ("at", tangents.point))]
        columns += [
            Column("measured_deg", factor * tangents.direction, _ANGLE),
            Column("sigma_deg", factor * tangents.sigma, _ANGLE),
        ]
        columns += _scalar_columns(result.tangent_residuals, "deg", factor, _ANGLE)
        columns += revision_columns(result, "tangent")
        columns.append(Column("directed", ["true" if s else "false" for s in tangents.directed]))
        found.append(Table("tangent_residuals", tuple(columns)))
    if len(network.distances):
        found.append(_distances_table(result))
    return tuple(found)


def _distances_table(result: AdjustmentResult) -> Table:
    """One row a distance, metres."""
    network, given = result.network, result.network.distances
    columns = []
    for end, name in enumerate(("from", "to")):
        station = zip(given.is_image[:, end], given.station[:, end], strict=True)
        ids = [(network.images if image else network.points).ids[k] for image, k in station]
        columns.append(Column(name, ids))
    columns.append(Column("between", ["images" if image else "points" for image in given.is_image[:, 0]]))
    columns += [Column("measured_m", given.length), Column("sigma_m", given.sigma)]
    columns += _scalar_columns(result.distance_residuals, "m", 1.0, "%.9g")
    columns += revision_columns(result, "distance")
    return Table("distance_residuals", tuple(columns))


def _seen_columns(result: AdjustmentResult, point: IntArray) -> list[Column]:
    observed, network = result.network.curve_observations, result.network
    return [
        Column("image", [network.images.ids[i] for i in observed.image[point]]),
        Column("spline", [network.curves[i].id for i in observed.curve[point]]),
    ]


def _location_columns(result: AdjustmentResult, *ends: tuple[str, IntArray]) -> list[Column]:
    """Locations of the measured points that an observation belongs to."""
    return [Column(f"u_{name}", result.curve_residuals.location[point], "%.9g") for name, point in ends]


def _scalar_columns(residuals: ScalarResiduals, unit: str, factor: float, decimals: str) -> list[Column]:
    return [
        Column(f"residual_{unit}", factor * residuals.residual, decimals),
        Column("redundancy", residuals.redundancy, _RATIO),
        Column("standardized", residuals.standardized, _RATIO),
        Column(
            f"minimal_detectable_bias_{unit}",
            factor * residuals.reliability.minimal_detectable_bias,
            decimals,
        ),
    ]


def prior_residuals_table(result: AdjustmentResult) -> Table:
    """One row a control, prior, gauge or datum equation: adjusted - given; degrees or metres."""
    priors = result.prior_residuals
    factor = np.where(priors.angular, 180.0 / np.pi, 1.0)
    columns = (
        Column("kind", priors.kind.tolist()),
        Column("subject", priors.subject.tolist()),
        Column("component", priors.component.tolist()),
        Column("unit", np.where(priors.angular, "deg", "m").tolist()),
        Column("residual", factor * priors.residual),
        Column("sigma", factor * priors.sigma),
        Column("redundancy", priors.redundancy, _RATIO),
        Column("standardized", priors.standardized, _RATIO),
        Column("minimal_detectable_bias", factor * priors.minimal_detectable_bias),
        Column("bias_to_noise", priors.bias_to_noise, "%.4f"),
    )
    return Table("prior_residuals", columns)


def _only(values: FloatArray, rows: slice) -> FloatArray:
    """A copy that keeps `rows` and is NaN elsewhere."""
    kept = np.full(len(values), np.nan)
    kept[rows] = values[rows]
    return kept


def _curve_ids(result: AdjustmentResult) -> list[str]:
    return [curve.id for curve in result.network.curves]
