"""The starter ``aerial``: two strips of four images with observed orientations, control points, roads and a pond."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.block_geometry import BlockGeometry
from splinebba_cli.simulation.feature_geometry import road, scattered_points, shore, tie_spline
from splinebba_cli.starters.catalogue import Starter
from splinebba_cli.starters.digital_camera import DigitalCamera
from splinebba_cli.starters.measured_scene import MeasuredScene, measured
from splinebba_cli.starters.tables import (
    image_point_table,
    knot_table,
    observed_orientation_table,
    point_table,
    spline_point_table,
    tie_point_table,
)
from splinebba_cli.starters.texts import project_texts

SEED = 1
CAMERA = DigitalCamera("cam-1", 80.0, 0.0046, (11608, 8708), (0.012, -0.008), 2.1e-6, -4.0e-10)
IMAGE_IDS = ("0101", "0102", "0103", "0104", "0201", "0202", "0203", "0204")
FLYING_HEIGHT_M = 800.0
BASE_M, STRIP_DISTANCE_M = 205.0, 270.0
ORIGIN = (4000.0, 8000.0, 0.0)
SIGMA_PX = 0.4
POSITION_SIGMA_M, HEIGHT_SIGMA_M, ANGLE_SIGMA_DEG, HEADING_SIGMA_DEG = 0.08, 0.12, 0.006, 0.012
GIVEN_SIGMA_M = 0.03
CONTROL = np.array([[-20, -40], [610, -30], [600, 320], [-10, 310], [310, 140]], dtype=float)
AREA = (-60.0, -80.0, 680.0, 360.0)
ROADS = {
    "road-1": road((-20.0, 60.0), (640.0, 210.0), 11, 22.0),
    "road-2": road((210.0, -90.0), (260.0, 370.0), 8, 18.0),
}
POND = shore((470.0, 95.0), 55.0, 8)


def starter() -> Starter:
    """The files of the starter."""
    network = measured(scene().design(), SEED, 0.8, 0.0)
    values = {
        **CAMERA.values(),
        "seed": SEED,
        "sigma_px": SIGMA_PX,
        "position_sigma_m": POSITION_SIGMA_M,
        "height_sigma_m": HEIGHT_SIGMA_M,
        "angle_sigma_deg": ANGLE_SIGMA_DEG,
        "heading_sigma_deg": HEADING_SIGMA_DEG,
        "given_sigma_m": GIVEN_SIGMA_M,
    }
    tables = {
        "images.csv": observed_orientation_table(network),
        "given_points.csv": point_table(network, ("control", "check")),
        "tie_points.csv": tie_point_table(network),
        "approximate_knots.csv": knot_table(network, [*ROADS, "pond"], 1),
        "image_points.csv": image_point_table(network, CAMERA),
        "spline_points.csv": spline_point_table(network, CAMERA),
    }
    return Starter({**project_texts("aerial", values), **tables})


def scene() -> MeasuredScene:
    """The block and what it measures."""
    features = (
        *(tie_spline(id, knots) for id, knots in ROADS.items()),
        tie_spline("pond", POND, closed=True),
    )
    horizontal, heading = np.radians([ANGLE_SIGMA_DEG, HEADING_SIGMA_DEG])
    sigma = np.array([horizontal, horizontal, heading, POSITION_SIGMA_M, POSITION_SIGMA_M, HEIGHT_SIGMA_M])
    points = scattered_points(AREA, CONTROL, 36, 6, GIVEN_SIGMA_M)
    return MeasuredScene(_block(), IMAGE_IDS, CAMERA, features, points, 20, SIGMA_PX, sigma)


def _block() -> BlockGeometry:
    """Strips flown there and back along X, nearly vertical."""
    generator = np.random.default_rng(3)
    eop: FloatArray = np.empty((8, 6))
    eop[:, :3] = generator.normal(0.0, np.radians(1.0), (8, 3))
    eop[4:, 2] += np.pi
    along = BASE_M * np.arange(4)
    eop[:, 3] = np.concatenate([along, along[::-1]])
    eop[:, 4] = np.repeat([0.0, STRIP_DISTANCE_M], 4)
    eop[:, 5] = FLYING_HEIGHT_M
    eop[:, 3:] += generator.normal(0.0, 5.0, (8, 3))
    return BlockGeometry(eop, CAMERA.principal_distance_mm, CAMERA.planned_format_mm(), np.array(ORIGIN))
