"""Pre-analysis: every standard deviation of a design before it is measured, at the truth and a priori.

One linearisation and one factorisation: with noise-free measurements the truth is the solution, so that the
dispersion (A'PA)^-1 there, with the gauge conditions that the adjustment would keep, is what an adjustment would
report with σ0 = 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import NotPositiveDefinite
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution, kept_conditions
from splinebba_cli.core.estimation.datum import minimal_datum
from splinebba_cli.core.estimation.gauss_markov import PIVOT_TOLERANCE, Solution
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import BoolArray, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows, concatenate_rows, gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.quality.determinacy import require_determined, require_rank
from splinebba_cli.core.quality.evaluation import Adjusted, evaluate
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.simulation.realization import Design
from splinebba_cli.simulation.truth import at_truth, true_state

ROUNDS = 8
# findings that only measured values can have: global and local tests, common and systematic errors, check features
_OF_RESIDUALS = (
    "SBB531", "SBB545", "SBB546", "SBB547", "SBB548", "SBB549", "SBB550", "SBB551", "SBB554", "SBB555", "SBB556",
    "SBB557",
)  # fmt: skip


@dataclass(frozen=True)
class RedundancySummary:
    """Redundancy numbers of one kind of observations."""

    kind: str
    count: int
    mean: float
    smallest: float
    share_weak: float  # of the observations with a redundancy number below 0.1


def predict(design: Design) -> AdjustmentResult:
    """What an adjustment of the design would report, without any measurement.

    Returns
    -------
    AdjustmentResult
        At the truth; dispersions a priori.  Residuals are 0, there is no σ̂₀ and no global test.

    Raises
    ------
    SingularNetworkError
        If something would not be determined; its problems name it and what would cure it.
    """
    network = at_truth(design.network, design.truth)
    network = _with_control_at_truth(network, design)
    network = replace(network, settings=replace(network.settings, scale_dispersion=False))
    prepared = prepare(network)
    solved = _solved(prepared, design)
    require_determined(prepared, solved)
    result = evaluate(Adjusted(prepared, solved, (), ()))
    statistics = replace(result.statistics, sigma0=float("nan"), global_test=None)
    problems = tuple(p for p in result.problems if p.code not in _OF_RESIDUALS)
    return replace(result, statistics=statistics, problems=problems)


def _with_control_at_truth(network: Network, design: Design) -> Network:
    """Priors at the truth: the equations of given values have no residual."""
    known = np.isfinite(network.images.prior_sigma)
    return replace(network, images=replace(network.images, prior=np.where(known, design.truth.eop, np.nan)))


def _solved(prepared: Prepared, design: Design) -> ConditionedSolution:
    """The factor at the truth with the conditions that an adjustment keeps."""
    settings, state = prepared.network.settings, _located(prepared, true_state(prepared, design.truth))
    layout = layout_of(prepared)
    if settings.datum != "control":
        layout = minimal_datum(prepared, layout, state)
    held = held_locations(prepared, state.location)
    control = control_rows(prepared, layout.coefficient_mask)
    gauge = gauge_rows(prepared, layout.coefficient_mask, settings.gauge_sigma_m)

    def with_conditions(chosen: BoolArray) -> ConditionedSolution:
        rows = concatenate_rows([control, gauge.select(np.flatnonzero(chosen))], prepared.curves.support)
        assembler = Assembler(prepared, layout, rows)
        at = assembler.linearize(state, held)
        if chosen.all():
            require_rank(assembler, at)
        try:
            values, _, eliminated = assembler.eliminate(at, 0.0)
            factor = assembler.symbolic(state).factorize(values, pivot_tolerance=PIVOT_TOLERANCE)
        except (NotPositiveDefinite, np.linalg.LinAlgError):
            return ConditionedSolution(
                assembler, Solution(at, None, None, False, "normal matrix is singular", ()), np.arange(0)
            )
        solution = Solution(at, factor, eliminated, True, "predicted", ())
        return ConditionedSolution(assembler, solution, np.flatnonzero(chosen))

    active = np.ones(len(gauge), dtype=bool)
    select = settings.gauge_conditions == "needed" and settings.knots.spacing_m is None
    return _with_needed(with_conditions, gauge) if select else with_conditions(active)


def _located(prepared: Prepared, state: State) -> State:
    """The state with foot points where the truth has no locations: a family that only approximates the true curve."""
    return state if np.isfinite(state.location).all() else search_locations(prepared, state)


def _with_needed(
    solve: Callable[[BoolArray], ConditionedSolution], gauge: CoefficientRows
) -> ConditionedSolution:
    """The solution with no more conditions than needed, by the rules of the adjustment."""
    active = np.ones(len(gauge), dtype=bool)
    best = solve(active)
    for _ in range(ROUNDS if len(gauge) else 0):
        if best.solution.factor is None:
            break
        keep = kept_conditions(gauge, active, best)
        if np.array_equal(keep, active):
            break
        found = solve(keep)
        if found.solution.factor is None:
            break
        active, best = keep, found
    return best


def redundancy_summary(result: AdjustmentResult) -> tuple[RedundancySummary, ...]:
    """How well the observations of each kind would check each other."""
    kinds: list[tuple[str, FloatArray]] = [
        ("points, x and y", result.point_residuals.redundancy.ravel()),
        ("points on splines, across", result.curve_residuals.redundancy[:, 0]),
        ("arc lengths", result.arc_residuals.redundancy),
        ("tangents", result.tangent_residuals.redundancy),
    ]
    priors = result.prior_residuals
    kinds += [(kind, priors.redundancy[priors.kind == kind]) for kind in dict.fromkeys(priors.kind.tolist())]
    return tuple(
        RedundancySummary(name, len(r), float(r.mean()), float(r.min()), float(np.mean(r < 0.1)))
        for name, r in kinds
        if len(r)
    )
