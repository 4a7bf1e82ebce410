"""Check points: adjusted - given, with the predicted dispersion of the difference.

    d = x - x_given,   C = s0^2 Q_x + diag(sigma_given^2)
    one point     d_n' C_nn^-1 d_n          3 degrees of freedom, Sidak's alpha of one of n tests
    together      d' C^-1 d                 3 n, C with the covariances between points
    mean          m' (G C G')^-1 m          3, m = G d: a systematic shift

chi-square where s0 is known; where it is estimated F with its redundancy, as x is independent of the residuals.
Given sigma are not scaled by s0, so that F is exact for sigma_given = 0 and else on the safe side.  Points are
correlated through the orientations; that all of n tests pass then has at least the probability of independent ones
(Gaussian correlation inequality, Royen 2014): the false alarm rate of the list is at most alpha.

Accuracies with that of the given coordinates, sqrt(RMSE^2 + RMSE_given^2), and the 3D one, sqrt(H^2 + V^2):
ASPRS Positional Accuracy Standards for Digital Geospatial Data, edition 2 (2023).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.joint_cofactors import point_cofactors, too_many
from splinebba_cli.core.quality.variance_factor import VarianceFactor
from splinebba_cli.core.result import CheckPoint, CheckPointSummary, CheckTest


def check_points(
    cofactors: Cofactors, variance: VarianceFactor
) -> tuple[tuple[CheckPoint, ...], CheckPointSummary | None]:
    """Differences of check points that are measured in at least two images, and all of them together."""
    network, state = cofactors.assembler.prepared.network, cofactors.solution.state
    rows = measured_checks(network)
    if not len(rows):
        return (), None
    difference = state.xyz[rows] - network.points.xyz[rows]
    sigma = np.nan_to_num(network.points.check_sigma[rows], posinf=0.0)
    own = cofactors.points.own[rows] * variance.scale + sigma[:, :, None] * np.eye(3) * sigma[:, None, :]
    square = np.einsum("ni,ni->n", difference, np.linalg.solve(own, difference[:, :, None])[:, :, 0])
    alpha = network.settings.alpha
    critical = variance.critical(single_alpha(alpha, "sidak", len(rows)), 3)
    together, shift = None, None
    if not too_many(cofactors, 3 * len(rows)):
        joint = point_cofactors(cofactors, rows) * variance.scale + np.diag(sigma.ravel() ** 2)
        together, shift = _joint_tests(difference, joint, variance, alpha)
    found = tuple(
        CheckPoint(
            network.points.ids[row],
            difference[n],
            np.sqrt(np.diagonal(own[n])),
            float(np.sqrt(square[n] / 3.0)),
            bool(square[n] <= critical),
        )
        for n, row in enumerate(rows)
    )
    beyond = int((square > critical).sum())
    single = float(np.sqrt(critical / 3.0))
    return found, summary_of(difference, sigma, alpha, single, beyond, together, shift)


def measured_checks(network: Network) -> IntArray:
    """Rows of the check points with given coordinates and two rays."""
    rays = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
    role = np.array([role == "check" for role in network.points.role], dtype=bool)
    return np.flatnonzero(role & (rays >= 2) & np.isfinite(network.points.xyz).all(axis=1))


def _joint_tests(
    difference: FloatArray, joint: FloatArray, variance: VarianceFactor, alpha: float
) -> tuple[CheckTest, CheckTest]:
    """All differences together, and their mean."""
    count = len(difference)
    sigma = np.sqrt(np.diagonal(joint))
    normal = difference.ravel() / sigma
    square = float(normal @ np.linalg.solve(joint / np.outer(sigma, sigma), normal))
    mean = difference.mean(axis=0)
    spread = joint.reshape(count, 3, count, 3).mean(axis=(0, 2))
    shift = float(mean @ np.linalg.solve(spread, mean))
    return variance.test(square, alpha, 3 * count), variance.test(shift, alpha, 3)


def summary_of(
    difference: FloatArray, sigma: FloatArray, alpha: float, critical: float, beyond: int,
    together: CheckTest | None, shift: CheckTest | None,
) -> CheckPointSummary:  # fmt: skip
    """Root mean squares, means and accuracies of differences (n, 3) with given sigma (n, 3)."""
    rmse, given = np.sqrt(np.mean(difference**2, axis=0)), np.sqrt(np.mean(sigma**2, axis=0))
    horizontal, vertical = float(np.hypot(rmse[0], rmse[1])), float(rmse[2])
    given_horizontal, given_vertical = float(np.hypot(given[0], given[1])), float(given[2])
    accuracy = np.hypot([horizontal, vertical], [given_horizontal, given_vertical])
    return CheckPointSummary(
        count=len(difference),
        rmse=rmse,
        mean=difference.mean(axis=0),
        largest=difference[np.argmax(np.abs(difference), axis=0), np.arange(3)],
        rmse_horizontal=horizontal,
        rmse_vertical=vertical,
        given_horizontal=given_horizontal,
        given_vertical=given_vertical,
        accuracy_horizontal=float(accuracy[0]),
        accuracy_vertical=float(accuracy[1]),
        accuracy_3d=float(np.hypot(accuracy[0], accuracy[1])),
        alpha=alpha,
        critical=critical,
        beyond=beyond,
        together=together,
        shift=shift,
    )
