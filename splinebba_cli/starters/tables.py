"""Tables of a starter as people write them: few columns, rounded numbers, pixels."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from splinebba_cli.core.network import Network
from splinebba_cli.project.network_tables import csv_text, orientations
from splinebba_cli.starters.digital_camera import DigitalCamera


def point_table(network: Network, roles: Collection[str], decimals: int = 3, with_role: bool = True) -> str:
    """Given points: id, role, coordinates in the user's frame, metres."""
    points = network.points
    xyz = points.xyz + network.origin
    rows = [
        [id, *([role] if with_role else []), *(f"{value:.{decimals}f}" for value in xyz[k])]
        for k, (id, role) in enumerate(zip(points.ids, points.role, strict=True))
        if role in roles
    ]
    return csv_text(["point", *(["role"] if with_role else []), "x", "y", "z"], rows)


def tie_point_table(network: Network) -> str:
    """Names of the tie points."""
    names = zip(network.points.ids, network.points.role, strict=True)
    return csv_text(["point"], [[id] for id, role in names if role == "tie"])


def observed_orientation_table(network: Network) -> str:
    """Observed exterior orientations: metres in the user's frame, degrees."""
    prior = network.images.prior
    position, angles = prior[:, 3:] + network.origin, np.degrees(prior[:, :3])
    rows = (
        [id, *(f"{v:.3f}" for v in position[k]), *(f"{v:.4f}" for v in angles[k])]
        for k, id in enumerate(network.images.ids)
    )
    return csv_text(["image", "x", "y", "z", "omega", "phi", "kappa"], rows)


def rough_orientation_table(network: Network) -> str:
    """Approximate exterior orientations: metres in the user's frame, degrees."""
    values = orientations(network.images, network.origin, "deg")
    rows = (
        [id, *(f"{v:.1f}" for v in values[k, :3]), *(f"{v:.2f}" for v in values[k, 3:])]
        for k, id in enumerate(network.images.ids)
    )
    return csv_text(["image", "x", "y", "z", "omega", "phi", "kappa"], rows)


def knot_table(network: Network, ids: Collection[str], decimals: int) -> str:
    """Approximate knots of splines, the splines under each other: metres in the user's frame."""
    rows = [
        [curve.id, *(f"{value:.{decimals}f}" for value in knot)]
        for curve in network.curves
        if curve.id in ids
        for knot in curve.values + network.origin
    ]
    return csv_text(["spline", "x", "y", "z"], rows)


def image_point_table(network: Network, camera: DigitalCamera) -> str:
    """Measured image points of object points, pixels."""
    seen = network.point_observations
    return _measured("point", seen.image, (network.points.ids[k] for k in seen.point), network, camera)


def spline_point_table(network: Network, camera: DigitalCamera) -> str:
    """Image points measured along splines, pixels."""
    seen = network.curve_observations
    return _measured("spline", seen.image, (network.curves[k].id for k in seen.curve), network, camera)


def _measured(
    kind: str, image: Iterable[int], features: Iterable[str], network: Network, camera: DigitalCamera
) -> str:
    seen = network.point_observations if kind == "point" else network.curve_observations
    pixels = camera.pixels(seen.photo_xy)
    rows = (
        [network.images.ids[i], feature, f"{column:.2f}", f"{row:.2f}"]
        for i, feature, (column, row) in zip(image, features, pixels, strict=True)
    )
    return csv_text(["image", kind, "x", "y"], rows)
