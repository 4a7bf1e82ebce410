"""The starter ``control-splines``: a flight over known lines, which are its only control."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import as_file, files

import numpy as np

from splinebba_cli.core.curves.fitting import fit_spline
from splinebba_cli.core.network import Curve, FloatArray
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import FitError, NotSolvableError, UsageError
from splinebba_cli.exchange.digitised_lines import DigitisedLine, ReadingOptions, read_digitised_lines
from splinebba_cli.project.writer import inline_spline_entry
from splinebba_cli.project.yaml_writing import sections_yaml
from splinebba_cli.simulation.feature_geometry import Feature
from splinebba_cli.simulation.prediction import predict
from splinebba_cli.simulation.realization import Design
from splinebba_cli.starters.catalogue import OF_POLYLINES, Polyline, Starter
from splinebba_cli.starters.digital_camera import DigitalCamera
from splinebba_cli.starters.flight import Flight, plan_flight, points_below
from splinebba_cli.starters.measured_scene import MeasuredScene, measured
from splinebba_cli.starters.tables import (
    image_point_table,
    point_table,
    rough_orientation_table,
    spline_point_table,
    tie_point_table,
)
from splinebba_cli.starters.texts import project_texts

SEED = 1
CAMERA = DigitalCamera("cam-1", 80.0, 0.0046, (11608, 8708), (0.012, -0.008), 2.1e-6, -4.0e-10)
SIGMA_PX, CONTROL_SIGMA_M, CHECK_SIGMA_M = 0.5, 0.05, 0.03
WEAKEST = 0.01  # largest σ of a station, of the flying height: beyond it the lines do not hold the block
STRAIGHT = 1e-3  # of its length: lines that leave one straight line by less
START = 0.01  # errors of approximate positions, of the flying height
OWN_LINES = "lines.geojson"
HELP = (
    "take several lines that wind, cross or lie apart from each other; one straight line leaves the block free to turn "
    "about it and to slide along it"
)


def starter(polyline: Polyline | None) -> Starter:
    """The files of the starter, over the lines of a file or over those of the program.

    Raises
    ------
    PointsFileError, FitError
        If the polyline is not one.
    UsageError
        SBB821, if it cannot carry a block.
    """
    if polyline is None:
        with as_file(files(__package__).joinpath("texts", OF_POLYLINES, OWN_LINES)) as path:
            return _over(Polyline(path))
    return _over(polyline)


def _over(polyline: Polyline) -> Starter:
    options = ReadingOptions(polyline.columns, polyline.height, polyline.cartesian)
    lines, warnings = read_digitised_lines(polyline.file, options)
    curves = _fitted(lines, polyline)
    _require_bent(np.vstack([curve.values for curve in curves]))
    origin = _origin(curves)
    flight = plan_flight(np.vstack([line.points for line in lines]) - origin, CAMERA, origin)
    design = _design(_true(curves, origin), flight)
    predicted = _carried(design, flight)
    copy = f"lines{polyline.file.suffix.lower()}"
    network = measured(design, SEED, START * flight.height_m, np.radians(1.0))
    values = {
        **CAMERA.values(),
        "seed": SEED,
        "sigma_px": SIGMA_PX,
        "control_sigma_m": CONTROL_SIGMA_M,
        "check_sigma_m": CHECK_SIGMA_M,
        "lines": copy,
        "threshold_m": f"{polyline.threshold_m:g}",
        "line_count": len(curves),
        "image_count": len(flight.image_ids),
        "height_m": f"{flight.height_m:.0f}",
        "gsd_m": f"{_ground_pixel(flight):.3f}",
        "start_m": f"{START * flight.height_m:.0f}",
        "largest_check_rmse_m": f"{_largest_rmse(predicted):.2f}",
        "splines": sections_yaml({"splines": [inline_spline_entry(curve) for curve in curves]}),
    }
    tables = {
        "images.csv": rough_orientation_table(network),
        "check_points.csv": point_table(network, ("check",), 3, with_role=False),
        "tie_points.csv": tie_point_table(network),
        "image_points.csv": image_point_table(network, CAMERA),
        "spline_points.csv": spline_point_table(network, CAMERA),
        copy: polyline.file.read_bytes().decode("utf-8-sig"),
    }
    return Starter({**project_texts(OF_POLYLINES, values), **tables}, warnings)


def _fitted(lines: Sequence[DigitisedLine], polyline: Polyline) -> tuple[Curve, ...]:
    """Control splines, rounded as they are written; ids of the file, else numbers."""
    out = []
    for number, line in enumerate(lines, start=1):
        id = line.id or f"line-{number}"
        try:
            spline = fit_spline(line.points, polyline.threshold_m, closed=line.closed)
        except FitError as error:
            raise FitError(error.code, f"line `{id}`: {error.message}", error.help) from None
        curve = spline.curve(id, "control", CONTROL_SIGMA_M)
        parameters = None if curve.knot_parameters is None else np.round(curve.knot_parameters, 4)
        out.append(replace(curve, values=np.round(curve.values, 4), knot_parameters=parameters))
    ids = [curve.id for curve in out]
    twice = next((id for id in ids if ids.count(id) > 1), None)
    if twice is not None:
        raise FitError(
            "SBB302", f"two lines have the id `{twice}`", "give each line of the file an id of its own"
        )
    return tuple(out)


def _require_bent(knots: FloatArray) -> None:
    """Not all knots (n, 3) lie on one straight line."""
    extents = np.linalg.svd(knots - knots.mean(axis=0), compute_uv=False)
    if not extents[1] > STRAIGHT * extents[0]:
        raise UsageError(
            "SBB821", "the polyline cannot carry a block: all of it lies on one straight line", HELP
        )


def _origin(curves: Sequence[Curve]) -> FloatArray:
    """A rounded place among the lines, metres; heights stay as they are."""
    mean = np.vstack([curve.values for curve in curves]).mean(axis=0)
    return np.array([*np.round(mean[:2], -2), 0.0])


def _true(curves: Sequence[Curve], origin: FloatArray) -> tuple[Curve, ...]:
    """What lies on the ground: not quite what the file says, by errors of the σ of the knots; local frame."""
    generator = np.random.default_rng(SEED)
    return tuple(
        replace(
            curve, values=curve.values - origin + generator.normal(0.0, CONTROL_SIGMA_M, curve.values.shape)
        )
        for curve in curves
    )


def _design(curves: Sequence[Curve], flight: Flight) -> Design:
    """Noise-free measurements of the lines, of tie points and of check points below the flight."""
    features = tuple(
        Feature(
            curve.id,
            "control",
            curve.values,
            curve.sigma,
            closed=curve.closed,
            knot_parameters=curve.knot_parameters,
        )
        for curve in curves
    )
    points = points_below(flight, np.vstack([curve.values for curve in curves]), CHECK_SIGMA_M)
    return MeasuredScene(flight.block, flight.image_ids, CAMERA, features, points, 25, SIGMA_PX).design()


def _carried(design: Design, flight: Flight) -> AdjustmentResult:
    """The predicted result of a block whose orientations are determined, and not by a hair."""
    try:
        result = predict(design)
    except NotSolvableError:
        message = (
            f"the polyline cannot carry a block: it leaves the orientations of {len(flight.image_ids)} images over it "
            "undetermined"
        )
        raise UsageError("SBB821", message, HELP) from None
    variances = np.diagonal(result.images.dispersion, axis1=1, axis2=2)[:, 3:]
    largest = float(np.sqrt(variances.max()))
    if not largest <= WEAKEST * flight.height_m:
        message = (
            f"the polyline cannot carry a block: perspective centres {flight.height_m:.0f} m above it would have "
            f"standard deviations of up to {largest:.3g} m"
        )
        raise UsageError("SBB821", message, HELP)
    return result


def _largest_rmse(predicted: AdjustmentResult) -> float:
    """A limit for check points that chance does not exceed: three times the largest σ of a difference, metres."""
    largest = max((float(point.sigma.max()) for point in predicted.checks.points), default=0.0)
    return 0.01 * math.ceil(300.0 * largest)


def _ground_pixel(flight: Flight) -> float:
    """Size of a pixel on the ground, metres."""
    return CAMERA.pixel_size_mm / CAMERA.principal_distance_mm * flight.height_m
