"""The starter ``close-range``: convergent images around an object with targets, a circle and two edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import Network, Role
from splinebba_cli.project.network_tables import csv_text
from splinebba_cli.simulation.block_geometry import ring
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures, circle_rows, tie_spline
from splinebba_cli.starters.catalogue import Starter
from splinebba_cli.starters.digital_camera import DigitalCamera
from splinebba_cli.starters.measured_scene import MeasuredScene, measured
from splinebba_cli.starters.tables import (
    image_point_table,
    knot_table,
    point_table,
    spline_point_table,
    tie_point_table,
)
from splinebba_cli.starters.texts import project_texts

SEED = 1
CAMERA = DigitalCamera("cam-1", 28.3, 0.0060, (6000, 4000), (0.021, 0.034), -1.1e-4, 1.5e-7)
IMAGE_IDS = tuple(f"IMG_{number:04d}" for number in range(1, 9))
SIGMA_PX, CONTROL_SIGMA_M, BAR_SIGMA_M = 0.3, 0.0003, 0.00005
BAR = ("target-1", "target-2")
CONTROL = np.array(
    [[-0.55, -0.55, 0.0], [0.55, -0.55, 0.04], [0.55, 0.55, 0.0], [-0.55, 0.55, 0.08], [0.02, 0.03, 0.5]]
)
SHARE = np.linspace(0.0, 1.0, 7)
EDGES = {
    "edge-1": np.column_stack([-0.5 + 0.1 * SHARE, -0.4 + 0.8 * SHARE, 0.1 + 0.28 * np.sin(2.5 * SHARE)]),
    "edge-2": np.column_stack([0.5 - 0.1 * SHARE, -0.4 + 0.8 * SHARE, 0.1 + 0.28 * np.sin(2.5 * SHARE)]),
}
RIM = circle_rows((0.0, 0.02, 0.45), 0.3, (0.05, -0.08, 1.0))


def starter() -> Starter:
    """The files of the starter."""
    network = measured(scene().design((BAR,), BAR_SIGMA_M), SEED, 0.01, 0.0)
    values = {
        **CAMERA.values(),
        "seed": SEED,
        "sigma_px": SIGMA_PX,
        "control_sigma_m": CONTROL_SIGMA_M,
        "bar_sigma_m": f"{BAR_SIGMA_M:.5f}",
        "rim": "\n".join(
            f"  - [{', '.join(f'{value:.2f}' for value in row)}]" for row in _values(network, "rim")
        ),
    }
    tables = {
        "images.csv": csv_text(["image"], [[id] for id in network.images.ids]),
        "control_points.csv": point_table(network, ("control",), 4, with_role=False),
        "tie_points.csv": tie_point_table(network),
        "approximate_knots.csv": knot_table(network, list(EDGES), 2),
        "image_points.csv": image_point_table(network, CAMERA),
        "spline_points.csv": spline_point_table(network, CAMERA),
        "scale_bars.csv": csv_text(["from", "to", "length"], [[*BAR, f"{network.distances.length[0]:.5f}"]]),
    }
    return Starter({**project_texts("close-range", values), **tables})


def scene() -> MeasuredScene:
    """The object and what is measured of it."""
    block = replace(
        ring(len(IMAGE_IDS)),
        principal_distance_mm=CAMERA.principal_distance_mm,
        format_mm=CAMERA.planned_format_mm(),
    )
    features = (
        Feature("rim", "tie", RIM, np.full_like(RIM, np.inf), family="circle"),
        *(tie_spline(id, knots) for id, knots in EDGES.items()),
    )
    return MeasuredScene(block, IMAGE_IDS, CAMERA, features, _targets(), 24, SIGMA_PX)


def _targets() -> PointFeatures:
    generator = np.random.default_rng(11)
    bar = np.array([[-0.5, -0.62, 0.02], [0.5, -0.61, 0.03]])
    xyz = np.vstack([bar, generator.uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 0.45], (18, 3))])
    ids = [f"gcp-{k + 1}" for k in range(len(CONTROL))] + [f"target-{k + 1}" for k in range(len(xyz))]
    kinds: tuple[tuple[Role, int], ...] = (("control", len(CONTROL)), ("tie", len(xyz)))
    role = tuple(name for name, count in kinds for _ in range(count))
    sigma = np.where(np.array(role)[:, None] == "tie", np.inf, CONTROL_SIGMA_M) * np.ones(3)
    return PointFeatures(tuple(ids), role, np.vstack([CONTROL, xyz]), sigma)


def _values(network: Network, id: str) -> list[list[float]]:
    curve = next(curve for curve in network.curves if curve.id == id)
    rows: list[list[float]] = (curve.values + np.outer([1.0, 0.0, 0.0], network.origin)).tolist()
    return rows
