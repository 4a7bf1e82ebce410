"""The adjustment inside the loop: labelled points, given measurements and priors, and the dispersions that follow.

Two solutions: with plain weights, then with those of Geman and McClure (1987) from its residuals, whose scale is three
sigma or more where residuals are larger.  Wrong labels of a round lose their weight that way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.control_network import control_network
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.gauss_markov import Observer, solution_at, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.matching.uncertainty import CurveCofactors, Uncertainty
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.revision.graduated_weights import last_scale, weights
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.errors import SingularNetworkError

CURVE_DAMPING = 1e-3
FAINT = 1e-6  # smallest weight


@dataclass(frozen=True)
class Labels:
    """Points that take part as measured points of curves; all arrays (n,)."""

    curve: IntArray  # -1: none
    location: FloatArray

    @property
    def rows(self) -> IntArray:
        """The points that have a label."""
        return np.flatnonzero(self.curve >= 0)


@dataclass(frozen=True)
class Round:
    """What an adjustment gives to the next round of matching."""

    state: State  # orientations, points and coefficients of all curves; no locations
    uncertainty: Uncertainty
    sigma0: float  # of the whole adjustment; NaN without redundancy
    converged: bool
    prepared: Prepared
    solved: ConditionedSolution


@dataclass(frozen=True)
class RoundNetwork:
    """A network with all its curves, of which a round adjusts some."""

    network: Network  # with priors (orientation_prior.py)
    curves: CurveSet  # of all
    kept: BoolArray  # (nc,) curves that take part
    iterations: int
    observer: Observer | None = None

    @property
    def coefficients(self) -> BoolArray:
        """Coefficients (C,) of curves that take part."""
        return np.repeat(self.kept, np.diff(self.curves.coefficient_start))


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
    try:
        found = _solved(problem, state, labels, None)
        if found is not None and robust and len(labels.rows):
            r = np.abs(found[1].solution.linearization.curve.residual[: _count(found[0])][-len(labels.rows) :])
            p = weights(r, last_scale(r, np.ones(len(r))), np.ones(len(r)))
            factor = np.ones(len(labels.curve))
            factor[labels.rows] = 1.0 / np.sqrt(np.maximum(p, FAINT))
            found = _solved(problem, _whole(problem, state, found[1]), labels, factor) or found
    except (FloatingPointError, np.linalg.LinAlgError, SingularNetworkError):
        return None
    if found is None:
        return None
    prepared, solved = found
    return Round(
        state=_whole(problem, state, solved),
        uncertainty=_uncertainty(problem, prepared, solved, before),
        sigma0=_sigma0(prepared, solved),
        converged=solved.solution.converged,
        prepared=prepared,
        solved=solved,
    )


def _count(prepared: Prepared) -> int:
    return len(prepared.network.curve_observations)


def _whole(problem: RoundNetwork, state: State, solved: ConditionedSolution) -> State:
    """The state of all curves after a solution with some of them."""
    found = solved.solution.state
    every = state.coefficients.copy()
    every[problem.coefficients] = found.coefficients
    return replace(found, coefficients=every, location=state.location)


def _solved(
    problem: RoundNetwork, state: State, labels: Labels, factor: FloatArray | None
) -> tuple[Prepared, ConditionedSolution] | None:
    """Solution with factors (n,) of the sigma of labelled points; None where the matrix is singular."""
    labelled = with_labels(problem.network, labels.curve, labels.location, factor)
    part, _ = control_network(labelled, problem.kept)
    prepared = prepare(part)
    begin = replace(
        state,
        coefficients=state.coefficients[problem.coefficients],
        location=part.curve_observations.location,
    )
    layout = datum_layout(prepared, begin)
    gauge = gauge_rows(prepared, layout.coefficient_mask, part.settings.gauge_sigma_m)
    control = control_rows(prepared, layout.coefficient_mask)
    assembler = Assembler(prepared, layout, concatenate_rows([control, gauge], prepared.curves.support))
    solution = solve(
        assembler, begin, max_iterations=problem.iterations, stage="matching",
        damping=CURVE_DAMPING if len(gauge) else 0.0, observer=problem.observer,
    )  # fmt: skip
    if solution.factor is None:
        reached = solution_at(assembler, solution.state)
        solution = replace(reached, converged=False, termination=solution.termination)
    if solution.factor is None:
        return None
    return prepared, ConditionedSolution(assembler, solution, np.arange(len(gauge)))


def _sigma0(prepared: Prepared, solved: ConditionedSolution) -> float:
    """Square root of v'Pv over the redundancy, priors and gauge conditions counted as measurements."""
    network, at = prepared.network, solved.solution.linearization
    count = len(network.curve_observations) + 2 * len(network.point_observations) + len(network.distances)
    count += len(solved.assembler.coefficient_rows) + int(at.orientation_priors.active.sum())
    count += int((np.isfinite(network.points.sigma) & (network.points.sigma > 0.0)).sum())
    redundancy = count - solved.assembler.layout.free_count
    return float(np.sqrt(at.cost / redundancy)) if redundancy > 0 else float("nan")


def _uncertainty(
    problem: RoundNetwork, prepared: Prepared, solved: ConditionedSolution, before: Uncertainty
) -> Uncertainty:
    """Dispersions of a solution, sigma 0 as stated; those of what takes no part as before."""
    count, factor = len(prepared.network.images.ids), solved.solution.factor
    assert factor is not None
    inverse = factor.selected_inverse()
    nodes = np.arange(count)
    mask = solved.assembler.layout.image_mask
    eop = np.asarray(inverse.blocks(nodes, nodes)) * mask[:, :, None] * mask[:, None, :]
    free = bool(solved.assembler.layout.coefficient_mask.any())
    cofactors = CurveCofactors.of(problem.kept, prepared, solved) if free else None
    return replace(before, eop=eop, cofactors=cofactors)
