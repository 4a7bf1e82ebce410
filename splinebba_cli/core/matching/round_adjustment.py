"""The adjustment inside the loop: labelled points, given measurements and priors, and the dispersions that follow.

Two solutions: with plain weights, then with those of Geman and McClure (1987) from its residuals, whose scale is three
sigma or more where residuals are larger.  Wrong labels of a round lose their weight that way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.approximation.control_network import control_network, known_curves
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.gauss_markov import Observer, solution_at, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.matching.held_feet import HeldPoints, at_feet
from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.uncertainty import CurveCofactors, Uncertainty
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.revision.graduated_weights import last_scale, weights
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.errors import SingularNetworkError

CURVE_DAMPING = 1e-3
FAINT = 1e-6  # smallest weight
FOOT_ROUNDS = 8
SETTLED = 0.05  # sigma: foot points that move less along their curves change nothing across


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
    scene: Scene  # of all curves at the state with which the round begins
    kept: BoolArray  # (nc,) curves that take part
    iterations: int
    observer: Observer | None = None

    @cached_property
    def held(self) -> BoolArray:
        """Curves (nc,) that are held and have no measurements but labels: their points are fixed points."""
        given = np.bincount(self.network.curve_observations.curve, minlength=len(self.kept)) > 0
        return known_curves(self.network) & ~given

    @cached_property
    def adjusted(self) -> BoolArray:
        """Curves (nc,) that take part as such."""
        return self.kept & ~self.held

    @property
    def coefficients(self) -> BoolArray:
        """Coefficients (C,) of adjusted curves."""
        return np.repeat(self.adjusted, np.diff(self.scene.curves.coefficient_start))


@dataclass(frozen=True)
class _Solved:
    """A solution with labelled points of both kinds."""

    prepared: Prepared
    solved: ConditionedSolution
    on_held: HeldPoints
    feet: FloatArray  # (k,) u of points on held curves
    adjusted_rows: IntArray  # unlabelled points that are measured points of adjusted curves

    def residuals(self, count: int) -> FloatArray:
        """Residuals across curves over the stated sigma, (n,); 0 of points without a label."""
        at = self.solved.solution.linearization
        found = np.zeros(count)
        if len(self.on_held):
            found[self.on_held.rows] = at.points.residual[-len(self.on_held) :, 0] * self.on_held.factor
        if len(self.adjusted_rows):
            measured = len(self.prepared.network.curve_observations)
            rows = at.curve.residual[:measured][-len(self.adjusted_rows) :]
            found[self.adjusted_rows] = rows
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
    count = len(labels.curve)
    try:
        found = _solved(problem, state, labels, np.ones(count))
        if found is not None and robust and len(labels.rows):
            r = np.abs(found.residuals(count)[labels.rows])
            p = weights(r, last_scale(r, np.ones(len(r))), np.ones(len(r)))
            factor = np.ones(count)
            factor[labels.rows] = 1.0 / np.sqrt(np.maximum(p, FAINT))
            found = _solved(problem, _whole(problem, state, found), labels, factor) or found
    except (FloatingPointError, np.linalg.LinAlgError, SingularNetworkError):
        return None
    if found is None:
        return None
    return Round(
        state=_whole(problem, state, found),
        uncertainty=_uncertainty(problem, found, before),
        sigma0=_sigma0(found),
        converged=found.solved.solution.converged,
        prepared=found.prepared,
        solved=found.solved,
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
    points = HeldPoints.of(problem.scene, on_held, labels.curve[on_held], factor[on_held])
    prepared = prepare(points.added_to(part) if len(points) else part)
    begin = replace(
        state,
        coefficients=state.coefficients[problem.coefficients],
        location=part.curve_observations.location,
        xyz=np.vstack([state.xyz, np.zeros((len(points), 3))]),
    )
    run = _FootRun(problem, points, labels.location[on_held], prepared)
    solved = run.solved(begin)
    if solved is None:
        return None
    return _Solved(run.prepared, solved, points, run.u, np.flatnonzero(others))


@dataclass
class _FootRun:
    """Solutions between which the foot points on held curves are sought again."""

    problem: RoundNetwork
    points: HeldPoints
    u: FloatArray  # (k,)
    prepared: Prepared

    def solved(self, state: State) -> ConditionedSolution | None:
        """The solution when the orientations no longer move; None where the matrix is singular."""
        state = self._moved_to_feet(state)
        layout = datum_layout(self.prepared, state)
        gauge = gauge_rows(
            self.prepared, layout.coefficient_mask, self.problem.network.settings.gauge_sigma_m
        )
        control = control_rows(self.prepared, layout.coefficient_mask)
        rows = concatenate_rows([control, gauge], self.prepared.curves.support)
        assembler = Assembler(self.prepared, layout, rows)
        damping = CURVE_DAMPING if len(gauge) else 0.0
        for _ in range(FOOT_ROUNDS if len(self.points) else 1):
            solution = solve(
                assembler, state, max_iterations=self._iterations(layout), stage="matching", damping=damping,
                observer=self.problem.observer,
            )  # fmt: skip
            before, state = state, self._moved_to_feet(solution.state)
            assembler = assembler.with_weights(self.prepared)
            if self._still(before, state):
                break
        if solution.factor is None or len(self.points):
            reached = solution_at(assembler, state)
            solution = replace(reached, termination=solution.termination)
        if solution.factor is None:
            return None
        return ConditionedSolution(assembler, solution, np.arange(len(gauge)))

    def _iterations(self, layout: ParameterLayout) -> int:
        """Of an adjustment between two searches for foot points: one where orientations are all there is."""
        alone = len(self.points) and not layout.coefficient_mask.any() and not layout.point_mask.any()
        return 1 if alone else self.problem.iterations

    def _moved_to_feet(self, state: State) -> State:
        if not len(self.points):
            return state
        self.u, xyz, self.prepared = at_feet(
            self.points, self.problem.scene.curves, self.problem.scene.polynomials, self.u, self.prepared, state
        )
        return replace(state, xyz=np.vstack([state.xyz[: len(state.xyz) - len(xyz)], xyz]))

    def _still(self, before: State, after: State) -> bool:
        """Whether foot points moved too little to matter across curves."""
        count = len(self.points)
        if not count:
            return True
        moved = np.linalg.norm(after.xyz[-count:] - before.xyz[-count:], axis=1)
        away = np.linalg.norm(after.xyz[-count:] - after.position[self.points.image], axis=1)
        seen = moved / away * self.prepared.principal_distance[self.points.image]
        sigma = self.points.factor / np.sqrt(np.abs(np.linalg.det(self.points.rays.whitening)))
        return bool(np.quantile(seen / sigma, 0.9) < SETTLED)


def _sigma0(found: _Solved) -> float:
    """Square root of v'Pv over the redundancy, priors and gauge conditions counted as measurements."""
    network, at = found.prepared.network, found.solved.solution.linearization
    count = len(network.curve_observations) + 2 * len(network.point_observations) + len(network.distances)
    count += len(found.solved.assembler.coefficient_rows) + int(at.orientation_priors.active.sum())
    count += int((np.isfinite(network.points.sigma) & (network.points.sigma > 0.0)).sum())
    redundancy = count - len(found.on_held) - found.solved.assembler.layout.free_count
    return float(np.sqrt(at.cost / redundancy)) if redundancy > 0 else float("nan")


def _uncertainty(problem: RoundNetwork, found: _Solved, before: Uncertainty) -> Uncertainty:
    """Dispersions of a solution, sigma 0 as stated; those of what takes no part as before."""
    solved = found.solved
    count, factor = len(found.prepared.network.images.ids), solved.solution.factor
    assert factor is not None
    nodes = np.arange(count)
    mask = solved.assembler.layout.image_mask
    eop = np.asarray(factor.selected_inverse().blocks(nodes, nodes)) * mask[:, :, None] * mask[:, None, :]
    free = bool(solved.assembler.layout.coefficient_mask.any())
    cofactors = CurveCofactors.of(problem.adjusted, found.prepared, solved) if free else None
    return replace(before, eop=eop, cofactors=cofactors)
