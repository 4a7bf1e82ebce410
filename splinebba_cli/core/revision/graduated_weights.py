"""A redescending estimator whose scale shrinks: p = 1 / (1 + (r / s)^2)^2, s from wide to narrow.

Errors of approximate values are larger than gross errors at first, but common to many points: they go while the scale
is wide.  The median breaks down at one half.  Nothing is drawn at random.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Linearization
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.revision.observation_list import CURVES, ObservationList
from splinebba_cli.core.revision.observation_weights import FAINT
from splinebba_cli.core.revision.reweighting import MAD_TO_SIGMA
from splinebba_cli.core.revision.weighted_solution import CURVE_DAMPING, WeightedNetwork
from splinebba_cli.core.state import State

WIDE = 4.0  # times the median residual of the start
SHRINKING = 0.67  # a step
NARROW = 3.0  # sigma: the last scale
ABOVE_MEDIAN = 1.5  # times the median residual: the scale does not outrun the convergence
STEPS = 60
STALLS = 3  # steps without a smaller scale that end it
ITERATIONS = 2  # of the adjustment a step
SETTLING = 20  # steps with the last scale
SETTLED = 0.01  # largest change of a weight


def graduated(network: WeightedNetwork, state: State, excluded: FloatArray) -> tuple[FloatArray, State]:
    """Weights (N,) and state when the scale has come down; `excluded` (N,) is 0 for what stays out, else 1.

    Weights of Geman and McClure (1987) for residuals r over sigma and a scale s,

        p = 1 / (1 + (r / s)^2)^2,

    begin with s so wide that the cost is nearly that of least squares and shrink it by a third from step to step
    (graduated non-convexity, Blake and Zisserman 1987), never below a multiple of the median of |r|, down to three
    sigma.
    """
    factor, scale, stalls = excluded, np.inf, 0
    for _ in range(STEPS):
        try:
            solution = network.iterate(factor, state, ITERATIONS, CURVE_DAMPING)
        except (FloatingPointError, np.linalg.LinAlgError):
            break
        state = solution.state
        r = residual_size(network.listed, solution.linearization, factor)
        median, before = usual_size(r, excluded), scale
        scale = max(last_scale(r, excluded), min(SHRINKING * scale, WIDE * median))
        factor = weights(r, scale, excluded)
        stalls = stalls + 1 if scale >= 0.99 * before else 0
        if stalls == STALLS:
            break
    return factor, state


def settled(
    network: WeightedNetwork, state: State, factor: FloatArray, excluded: FloatArray
) -> tuple[float, FloatArray, State]:
    """Robust cost, weights (N,) and state after more steps with the last scale; all of them nearly right before."""
    cost = np.inf
    for _ in range(SETTLING):
        try:
            solution = network.iterate(factor, state, ITERATIONS, CURVE_DAMPING)
        except (FloatingPointError, np.linalg.LinAlgError):
            break
        state = solution.state
        before, r = factor, residual_size(network.listed, solution.linearization, factor)
        factor, cost = weights(r, last_scale(r, excluded), excluded), float(costs(r, NARROW, excluded).sum())
        if np.abs(factor - before).max(initial=0.0) <= SETTLED:
            break
    return cost, factor, state


def costs(r: FloatArray, scale: float, excluded: FloatArray) -> FloatArray:
    """What these weights make least in sum: r^2 / (1 + (r / s)^2) of residuals (N,)."""
    return np.asarray(excluded * r**2 / (1.0 + (r / scale) ** 2))


def usual_size(r: FloatArray, excluded: FloatArray) -> float:
    """What the median of residuals (N,) says of their sigma."""
    return MAD_TO_SIGMA * float(np.median(r[excluded > 0.0]))


def last_scale(r: FloatArray, excluded: FloatArray) -> float:
    """Three sigma, or more where most residuals (N,) are larger than their sigma allow."""
    return max(NARROW, ABOVE_MEDIAN * usual_size(r, excluded))


def weights(r: FloatArray, scale: float, excluded: FloatArray) -> FloatArray:
    """Weights p = 1 / (1 + (r / s)^2)^2 of residuals (N,), 0 for what stays out."""
    return np.asarray(excluded / (1.0 + (r / scale) ** 2) ** 2)


def residual_size(listed: ObservationList, at: Linearization, factor: FloatArray | float = 1.0) -> FloatArray:
    """|r| over the given sigma of every entry, (N,): of one coordinate of a point, across curves.

    Parameters
    ----------
    factor : (N,) of the weights of the linearisation
    """
    whitened = np.zeros(len(listed))
    whitened[: len(at.points.residual)] = np.sqrt(0.5 * np.sum(at.points.residual**2, axis=1))
    count = len(at.curve.speed)
    listed.part(whitened, CURVES)[:] = np.abs(at.curve.residual[:count])
    whitened[listed.starts[CURVES + 1] :] = np.abs(
        np.concatenate([at.linked.arc_residual, at.linked.tangent_residual, at.distances.residual])
    )
    return np.asarray(whitened / np.sqrt(np.maximum(factor, FAINT)))
