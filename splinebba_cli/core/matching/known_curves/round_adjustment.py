"""The adjustment inside the loop: labelled points, given measurements and priors, and the dispersions that follow.

Two solutions: with plain weights, then with those of Geman and McClure (1987) from its residuals, whose scale is three
sigma or more where residuals are larger.  Wrong labels of a round lose their weight that way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.control_network import control_network
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.matching.known_curves.foot_rounds import FootRun
from splinebba_cli.core.matching.known_curves.held_feet import HeldPoints
from splinebba_cli.core.matching.known_curves.round_network import Labels, RoundNetwork
from splinebba_cli.core.matching.known_curves.uncertainty import CurveCofactors, Uncertainty
from splinebba_cli.core.matching.known_curves.unit_variance import UnitVariance, unit_variance
from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.revision.graduated_weights import last_scale, weights
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.errors import SingularNetworkError

FAINT = 1e-6  # smallest weight


@dataclass(frozen=True)
class Round:
    """What an adjustment gives to the next round of matching."""

    state: State  # orientations, points and coefficients of all curves; no locations
    uncertainty: Uncertainty
    fit: UnitVariance  # of the whole adjustment


@dataclass(frozen=True)
class _Solved:
    """A solution with labelled points of both kinds."""

    prepared: Prepared
    solved: ConditionedSolution
    on_held: HeldPoints
    adjusted_rows: IntArray  # unlabelled points that are measured points of adjusted curves
    factor: FloatArray  # (n,) of the sigma of labelled points

    def residuals(self, count: int) -> FloatArray:
        """Residuals across curves over the stated sigma, (n,); 0 of points without a label."""
        at = self.solved.solution.linearization
        found = np.zeros(count)
        if len(self.on_held):
            found[self.on_held.rows] = at.points.residual[-len(self.on_held) :, 0] * self.on_held.factor
        if len(self.adjusted_rows):
            measured = len(self.prepared.network.curve_observations)
            rows = at.curve.residual[:measured][-len(self.adjusted_rows) :]
            found[self.adjusted_rows] = rows * self.factor[self.adjusted_rows]
        return found


def adjust_round(
    problem: RoundNetwork, state: State, labels: Labels, before: Uncertainty, *, robust: bool
) -> Round | None:
    """Adjust a network with labels; None where there is no solution.

    Parameters
    ----------
    state : with coefficients (C, 3) of all curves
    labels : on curves that take part
    before : dispersions of what takes no part
    robust : whether residuals get weights
    """
    count, scale = len(labels.curve), np.inf
    try:
        found = _solved(problem, state, labels, np.ones(count))
        if found is not None and robust and len(labels.rows):
            r = np.abs(found.residuals(count)[labels.rows])
            scale = last_scale(r, np.ones(len(r)))
            factor = np.ones(count)
            factor[labels.rows] = 1.0 / np.sqrt(np.maximum(weights(r, scale, np.ones(len(r))), FAINT))
            weighted = _solved(problem, _whole(problem, state, found), labels, factor)
            found, scale = (found, np.inf) if weighted is None else (weighted, scale)
    except (FloatingPointError, np.linalg.LinAlgError, SingularNetworkError):
        return None
    if found is None:
        return None
    return Round(
        state=_whole(problem, state, found),
        uncertainty=_uncertainty(problem, found, before),
        fit=_fit(found, labels.rows, scale),
    )


def _whole(problem: RoundNetwork, state: State, found: _Solved) -> State:
    """The state of all curves after a solution with some of them."""
    after = found.solved.solution.state
    every = state.coefficients.copy()
    every[problem.coefficients] = after.coefficients
    return replace(after, coefficients=every, location=state.location, xyz=after.xyz[: len(state.xyz)])


def _solved(problem: RoundNetwork, state: State, labels: Labels, factor: FloatArray) -> _Solved | None:
    """Solution with factors (n,) of the sigma of labelled points; None where the matrix is singular."""
    rows = labels.rows
    on_held = rows[problem.held[labels.curve[rows]]]
    others = np.append(~problem.held, False)[labels.curve]
    network = with_labels(problem.network, np.where(others, labels.curve, -1), labels.location, factor)
    part, _ = control_network(network, problem.adjusted)
    points = HeldPoints(problem.network, problem.scene, on_held, labels.curve[on_held], factor[on_held])
    prepared = prepare(points.added_to(part) if len(points) else part)
    begin = replace(
        state,
        coefficients=state.coefficients[problem.coefficients],
        location=part.curve_observations.location,
        xyz=np.vstack([state.xyz, np.zeros((len(points), 3))]),
    )
    run = FootRun(problem, points, labels.location[on_held], prepared)
    solved = run.solved(begin)
    if solved is None:
        return None
    return _Solved(run.prepared, solved, points, np.flatnonzero(others), factor)


def _fit(found: _Solved, labelled: IntArray, scale: float) -> UnitVariance:
    """Variance of unit weight, priors and gauge conditions counted as measurements.

    Parameters
    ----------
    labelled : points with a label
    scale : of their weights
    """
    network, at = found.prepared.network, found.solved.solution.linearization
    count = len(network.curve_observations) + 2 * len(network.point_observations) + len(network.distances)
    count += len(found.solved.assembler.coefficient_rows) + int(at.orientation_priors.active.sum())
    count += int((np.isfinite(network.points.sigma) & (network.points.sigma > 0.0)).sum())
    others = count - len(found.on_held) - len(labelled)
    weight = float(np.sum(found.factor[labelled] ** -2))
    unknowns = found.solved.assembler.layout.free_count
    return unit_variance(at.cost, others, weight, unknowns, scale)


def _uncertainty(problem: RoundNetwork, found: _Solved, before: Uncertainty) -> Uncertainty:
    """Dispersions of a solution, sigma 0 as stated; those of what takes no part as before."""
    solved = found.solved
    count, factor = len(found.prepared.network.images.ids), solved.solution.factor
    assert factor is not None
    nodes = np.arange(count)
    mask = solved.assembler.layout.image_mask
    eop = np.asarray(factor.selected_inverse().blocks(nodes, nodes)) * mask[:, :, None] * mask[:, None, :]
    held = ~mask.any(axis=1)
    eop[held] = before.eop[held] * before.inflation
    free = bool(solved.assembler.layout.coefficient_mask.any())
    cofactors = CurveCofactors.of(problem.adjusted, found.prepared, solved) if free else None
    return replace(before, eop=eop, cofactors=cofactors)
