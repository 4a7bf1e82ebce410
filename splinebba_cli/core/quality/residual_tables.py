"""Residuals, redundancy numbers and standardised residuals of all observations, in the user's measured frames."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.reliability import reliability, standardized_residuals
from splinebba_cli.core.result import ResidualTable, ScalarResiduals
from splinebba_cli.core.state import Prepared


def point_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> ResidualTable:
    """Residuals of the image points of points; `delta0` is the noncentrality of their tests."""
    whitened = solved.solution.linearization.points.residual
    observed = prepared.network.point_observations
    missing = np.full(len(observed), np.nan)
    return ResidualTable(
        residual=whitened * observed.sigma,
        across=missing,
        redundancy=numbers.image_points,
        standardized=standardized_residuals(whitened, numbers.image_points),
        location=missing,
        location_sigma=missing,
        normal=np.full((len(observed), 2), np.nan),
        reliability=reliability(observed.sigma, numbers.image_points, numbers.point_orientation, delta0),
    )


def curve_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, location_sigma: FloatArray,
    delta0: float,
) -> ResidualTable:  # fmt: skip
    """Residuals of the image points of curves: across, and along where the location is held or linked to others."""
    rows, linked = numbers.curve, np.flatnonzero(prepared.chains.linked)
    observed = prepared.network.curve_observations
    count = len(observed)
    held = rows.along
    across = rows.residual[:count]
    unit = np.stack([rows.normal[:, 1], -rows.normal[:, 0]], axis=1)
    along = np.zeros(count)
    along[held] = rows.residual[count:]
    along[linked] = solved.solution.linearization.linked.along[linked]
    redundancy = np.zeros((count, 2))
    redundancy[:, 0] = numbers.curve_rows[:count]
    redundancy[held, 1] = numbers.curve_rows[count:]
    redundancy[linked, 1] = numbers.linked_along[linked]
    tested = np.concatenate([held, linked])
    standardized = np.full((count, 2), np.nan)
    standardized[:, 0] = standardized_residuals(across, redundancy[:, 0])
    standardized[tested, 1] = standardized_residuals(along[tested], redundancy[tested, 1])
    across_vector = rows.normal * across[:, None] * observed.sigma
    residual = across_vector + unit * along[:, None] * observed.sigma
    # a normal in measured photo axes: whitening by equal sigma does not turn it
    normal = rows.normal / observed.sigma
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    sigma = np.stack([np.linalg.norm(n * observed.sigma, axis=1) for n in (rows.normal, unit)], axis=1)
    share = np.stack([numbers.curve_orientation[:count], np.zeros(count)], axis=1)
    share[held, 1] = numbers.curve_orientation[count:]
    share[linked, 1] = 1.0 - numbers.linked_along[linked]  # an upper bound
    measured = np.isfinite(redundancy)
    measured[:, 1] = False
    measured[tested, 1] = True
    return ResidualTable(
        residual=residual,
        across=np.sign(across) * np.linalg.norm(across_vector, axis=1),
        redundancy=redundancy,
        standardized=standardized,
        location=solved.solution.state.location,
        location_sigma=location_sigma,
        normal=normal,
        reliability=reliability(sigma, np.where(measured, redundancy, np.nan), share, delta0),
    )


def arc_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> ScalarResiduals:
    """Residuals of the arc lengths, mm."""
    whitened = solved.solution.linearization.linked.arc_residual
    return _scalar_table(whitened, prepared.network.arc_lengths.sigma, numbers.arc_lengths, delta0)


def tangent_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> ScalarResiduals:
    """Residuals of the tangents, rad."""
    whitened = solved.solution.linearization.linked.tangent_residual
    return _scalar_table(whitened, prepared.network.tangents.sigma, numbers.tangents, delta0)


def distance_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> ScalarResiduals:
    """Residuals of the distances, m."""
    whitened = solved.solution.linearization.distances.residual
    return _scalar_table(whitened, prepared.network.distances.sigma, numbers.distances, delta0)


def _scalar_table(
    whitened: FloatArray, sigma: FloatArray, redundancy: FloatArray, delta0: float
) -> ScalarResiduals:
    found = reliability(sigma, redundancy, 1.0 - redundancy, delta0)
    return ScalarResiduals(
        whitened * sigma, sigma, redundancy, standardized_residuals(whitened, redundancy), found
    )
