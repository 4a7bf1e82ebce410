"""adjust(network): approximate values, staged estimation, quality, in order.

Stages keep wrong starts out of false minima (theory, section 6): what the points alone determine comes first (without
points: the control splines), then the curves with the orientations held, then everything together.
"""

from __future__ import annotations

import logging
import time
from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.control_network import (
    POINTS_NEEDED,
    control_network,
    control_orients,
    points_only,
)
from splinebba_cli.core.approximation.curve_refinement import calmed, refine_curves
from splinebba_cli.core.approximation.misfit import told_of_misfit
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution, solve_with_conditions
from splinebba_cli.core.estimation.datum import datum_layout, free_directions
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import KnotPolicy, Network
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.observations.structural_locations import structural_state
from splinebba_cli.core.quality.determinacy import (
    rank_is_looked_at,
    require_determined,
    require_rank,
    weak_images,
)
from splinebba_cli.core.quality.evaluation import Adjusted, evaluate
from splinebba_cli.core.quality.inner_datum import fitted_state
from splinebba_cli.core.quality.moved_references import with_moved_references
from splinebba_cli.core.result import AdjustmentResult, Iteration, Problem
from splinebba_cli.core.revision.restoration import restored
from splinebba_cli.core.revision.revise import Search, begin_search, robust_start
from splinebba_cli.core.revision.search_and_weights import searched_and_weighted
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare
from splinebba_cli.errors import NotConvergedError, SingularNetworkError

_log = logging.getLogger(__name__)

CURVE_DAMPING = 1e-3  # starting value where curves are adjusted
CALMING_ROUNDS = 4
PATIENCE = 4  # times the iterations for the last attempt
REFINEMENT_ROUNDS = 2
DATUM_ROUNDS = 2
ENOUGH = 0.995  # of the cost: less gain is not worth another round


def adjust(
    network: Network, *, observer: Observer | None = None, full_dispersion: bool = False
) -> AdjustmentResult:
    """Adjust a network.

    Parameters
    ----------
    observer : called after every iteration
    full_dispersion : compute the full dispersion matrix as well (small networks)

    Raises
    ------
    SingularNetworkError
        If something is not determined; its problems name it and what would cure it.
    NotConvergedError
        If the iterations do not end with a negligible step.
    """
    with told_of_misfit(network):
        return _adjusted(network, observer, full_dispersion)


def _adjusted(network: Network, observer: Observer | None, full_dispersion: bool) -> AdjustmentResult:
    begin = time.perf_counter()
    log: list[Iteration] = []

    def record(iteration: Iteration) -> None:
        log.append(iteration)
        if observer:
            observer(iteration)

    def resolve(prepared: Prepared, state: State) -> ConditionedSolution:
        return _solve(prepared, state, record, "joint", select=True)

    _log.info("approximate values")
    search = begin_search(network)
    prepared = prepare(search.part.network)
    start, problems = starting_state(prepared)
    state, started = start, time.perf_counter()
    _log.info("adjustment")
    search, prepared, state = _begun(search, prepared, state, record)
    prepared, solved = _final(prepared, state, record)
    found = searched_and_weighted(search, prepared, solved, resolve, record)
    revised = found.revised
    prepared, solved = revised.prepared, revised.solved
    if network.settings.datum != "control":
        prepared, solved = _in_free_datum(prepared, solved, start, record)
    solution_end = time.perf_counter()
    adjusted = Adjusted(prepared, solved, (*problems, *found.problems), tuple(log), found.weights)
    result = restored(evaluate(adjusted, full_dispersion=full_dispersion), revised)
    timings = {
        "approximation_s": started - begin,
        "estimation_s": solution_end - started,
        "quality_s": time.perf_counter() - solution_end,
    }
    return replace(result, timings=timings)


def _begun(
    search: Search, prepared: Prepared, state: State, record: Observer
) -> tuple[Search, Prepared, State]:
    """Search, network and state with which the joint adjustment begins.

    A high-breakdown start that has solved everything together is better than stages; knots of its own choice the
    program can only find in stages.
    """
    settings = search.network.settings
    if settings.outliers.start == "high_breakdown":
        robust = robust_start(search, prepared, state, record)
        search, prepared, state = robust.search, robust.prepared, robust.state
        if robust.solved and settings.knots == KnotPolicy():
            return search, prepared, state
    return search, *_staged(prepared, state, record)


def _staged(prepared: Prepared, state: State, record: Observer) -> tuple[Prepared, State]:
    """Network and state after the points-only and the curves-only stage, where the network allows them."""
    network = prepared.network
    if not network.settings.staged or not network.curves:
        return prepared, state
    if len(network.point_observations) >= POINTS_NEEDED:
        alone = replace(state, coefficients=np.zeros((0, 3)), location=np.zeros(0))
        try:
            solution = _solve(prepare(points_only(network)), alone, record, "points").solution
        except FloatingPointError:  # named by the joint adjustment
            return prepared, state
        if not solution.converged:
            return prepared, state
        after = solution.state
        state = replace(state, rotation=after.rotation, position=after.position, xyz=after.xyz)
    else:
        state = _oriented_by_control(prepared, state, record)
        if network.settings.knots == KnotPolicy():
            return prepared, state
    return refine_curves(prepared, state, record)


def _oriented_by_control(prepared: Prepared, state: State, record: Observer) -> State:
    """The state with orientations from the control splines alone, where these determine every image; else as it is.

    A tie spline whose approximate shape is as wrong as the orientations would only hold them where they are.
    """
    network = prepared.network
    if not control_orients(network):
        return state
    part, rows = control_network(network)
    alone = prepare(part)
    begin = replace(state, coefficients=initial_coefficients(alone), location=state.location[rows])
    try:
        solved = _solve(alone, begin, record, "control", patience=PATIENCE)
    except (FloatingPointError, SingularNetworkError):  # named by the joint adjustment
        return state
    if not solved.solution.converged or weak_images(alone, solved):
        return state
    after = solved.solution.state
    return replace(state, rotation=after.rotation, position=after.position)


def _solve(
    prepared: Prepared, state: State, record: Observer, stage: str, *, select: bool = False, patience: int = 1
) -> ConditionedSolution:
    """Solve one stage; knots that the program spaces itself keep all their conditions."""
    settings = prepared.network.settings
    layout = datum_layout(prepared, state)
    control = control_rows(prepared, layout.coefficient_mask)
    gauge = gauge_rows(prepared, layout.coefficient_mask, settings.gauge_sigma_m)
    return solve_with_conditions(
        prepared, layout, control, gauge, state,
        max_iterations=patience * settings.max_iterations, stage=stage, damping=CURVE_DAMPING if len(gauge) else 0.0,
        observer=record, select=select and settings.gauge_conditions == "needed" and settings.knots.spacing_m is None,
    )  # fmt: skip


def _final(prepared: Prepared, state: State, record: Observer) -> tuple[Prepared, ConditionedSolution]:
    """The joint solution, or the reason why there is none."""
    try:
        _require_rank(prepared, state)
        prepared, solved = _joint(prepared, state, record)
        if prepared.network.settings.knots.spacing_m is not None and solved.solution.converged:
            prepared, solved = _with_better_curves(prepared, solved, record)
    except FloatingPointError as error:
        problem = Problem(
            "SBB505", "error", str(error), "approximate values", "check signs, units and rotation sequence"
        )
        raise NotConvergedError([problem]) from error
    require_determined(prepared, solved)
    return prepared, solved


def _in_free_datum(
    prepared: Prepared, solved: ConditionedSolution, start: State, record: Observer
) -> tuple[Prepared, ConditionedSolution]:
    """The solution in its datum, gauge conditions moved along with it so that residuals do not depend on the datum."""
    if not free_directions(prepared, layout_of(prepared), solved.solution.state).count:
        return prepared, solved
    inner = prepared.network.settings.datum == "inner"
    reference = replace(start, coefficients=initial_coefficients(prepared))
    first = prepared
    for _ in range(DATUM_ROUNDS if len(solved.conditions) else 1):
        if not inner and not len(solved.conditions):
            break
        state = solved.solution.state
        if inner:
            state = fitted_state(prepared, state, reference)
        prepared = with_moved_references(first, start, state)
        solved = _solve(prepared, state, record, "datum", select=True)
        require_determined(prepared, solved)
    return prepared, solved


def _require_rank(prepared: Prepared, state: State) -> None:
    """Refuse at the start what no iteration can solve, where the network is small enough to see it."""
    layout = datum_layout(prepared, state)
    if not rank_is_looked_at(layout):
        return
    rows = [
        control_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, prepared.network.settings.gauge_sigma_m),
    ]
    structure = structural_state(prepared, state)
    assembler = Assembler(structure.prepared, layout, concatenate_rows(rows, prepared.curves.support))
    require_rank(assembler, assembler.linearize(structure.state, structure.held))


def _joint(prepared: Prepared, state: State, record: Observer) -> tuple[Prepared, ConditionedSolution]:
    """Everything together; curves that keep it from settling get other knots where the settings allow that."""
    solved = _solve(prepared, state, record, "joint", select=True)
    if not prepared.network.settings.knots.drop:
        return prepared, solved
    for _ in range(CALMING_ROUNDS):
        if solved.solution.converged or not solved.solution.restless:
            return prepared, solved
        prepared, state = calmed(prepared, solved.solution.state, solved.solution.restless, record)
        solved = _solve(prepared, state, record, "joint", select=True)
    if not solved.solution.converged:
        solved = _solve(prepared, solved.solution.state, record, "joint", select=True, patience=PATIENCE)
    return prepared, solved


def _with_better_curves(
    prepared: Prepared, solved: ConditionedSolution, record: Observer
) -> tuple[Prepared, ConditionedSolution]:
    """Curves refined once more with the joint orientations, as long as the joint solution gains by it."""
    for _ in range(REFINEMENT_ROUNDS):
        other, state = refine_curves(prepared, solved.solution.state, record, spaced=True)
        other, trial = _joint(other, state, record)
        cost = solved.solution.linearization.cost
        if not trial.solution.converged or trial.solution.linearization.cost > cost:
            break
        prepared, solved = other, trial
        if trial.solution.linearization.cost > ENOUGH * cost:
            break
    return prepared, solved
