"""Check points and check splines: adjusted against given, with the predicted precision of the difference."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.given_shape import given_points
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import CheckPoint, CheckSpline
from splinebba_cli.core.state import Prepared, State


def check_points(network: Network, xyz: FloatArray, dispersion: FloatArray) -> tuple[CheckPoint, ...]:
    """Differences of check points that are measured in at least two images."""
    rays = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
    found = []
    for k, id_ in enumerate(network.points.ids):
        if network.points.role[k] != "check" or rays[k] < 2 or not np.isfinite(network.points.xyz[k]).all():
            continue
        sigma = network.points.check_sigma[k]
        given = np.where(np.isfinite(sigma), sigma, 0.0)
        difference = xyz[k] - network.points.xyz[k]
        covariance = dispersion[k] + np.diag(given**2)
        normalized = float(np.sqrt(difference @ np.linalg.solve(covariance, difference) / 3.0))
        found.append(CheckPoint(id_, difference, np.sqrt(np.diag(covariance)), normalized))
    return tuple(found)


def check_splines(prepared: Prepared, state: State, sigma_across: FloatArray) -> tuple[CheckSpline, ...]:
    """Distances of the given points of check splines from the adjusted curves, normal to them, metres.

    Given points beyond an end of an open curve have no foot point on it: their distance is NaN.
    """
    found = []
    for k, curve in enumerate(prepared.network.curves):
        if curve.role != "check":
            continue
        given = curve.check_values if curve.check_values is not None else given_points(curve)
        start, stop = prepared.curves.coefficient_start[k], prepared.curves.coefficient_start[k + 1]
        basis = prepared.curves.bases[k]
        u, distance = nearest_on_curve(basis, state.coefficients[start:stop], given)
        inside = np.ones(len(u), dtype=bool)
        if not basis.closed:
            inside = (u > basis.break_points[0]) & (u < basis.break_points[-1])
        distance = np.where(inside, distance, np.nan)
        chosen = distance[inside] if inside.any() else np.full(1, np.nan)
        found.append(
            CheckSpline(
                curve.id,
                distance,
                float(np.sqrt(np.mean(chosen**2))),
                float(chosen.max()),
                float(sigma_across[k]),
            )
        )
    return tuple(found)
