"""Curves alone, orientations held: every curve has its own damping, cost and convergence.

With the orientations held the normal matrix falls into one block a curve.  All blocks are factored together, but a
step is accepted curve by curve, so that one curve that would fold does not stop the others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import NotPositiveDefinite
from splinebba_cli.core.estimation.block_matrix import BlockMatrix
from splinebba_cli.core.estimation.curve_folding import folded_segments
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.estimation.stretches import curve_costs
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations, refine_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.result import Iteration
from splinebba_cli.core.state import Prepared, State, on_shape

START_DAMPING, SMALLEST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-8, 1e6
SETTLED = 1e-3  # relative decrease below which a curve has settled well enough for a start


def curves_alone(prepared: Prepared, sliding: float = 1.0) -> Assembler:
    """Equations of all curves with the orientations held and all gauge conditions kept.

    Parameters
    ----------
    sliding : factor of the sigma of gauge conditions
    """
    layout = layout_of(prepared).hold_images()
    gauge = gauge_rows(prepared, layout.coefficient_mask, prepared.network.settings.gauge_sigma_m)
    rows = [control_rows(prepared, layout.coefficient_mask), gauge.with_sigma_times(sliding)]
    return Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))


def solve_curves(
    assembler: Assembler,
    state: State,
    *,
    max_iterations: int,
    stage: str = "curves",
    observer: Observer | None = None,
) -> State:
    """Improve all curves with the orientations (and points) held, as a start for a joint solution.

    Parameters
    ----------
    assembler : of a layout whose images are held

    Returns
    -------
    State
        With curves no worse than before, each by itself.
    """
    curve_count = len(assembler.prepared.curves.bases)
    damping = np.full(curve_count, START_DAMPING)
    settled = np.zeros(curve_count, dtype=bool)
    state = search_locations(assembler.prepared, state)
    at = assembler.linearize(state, held_locations(assembler.prepared, state.location))
    cost = curve_costs(assembler, at)
    folds = folded_segments(assembler.prepared, state.coefficients)
    for number in range(1, max_iterations + 1):
        trial_state = _step(assembler, at, damping)
        trial, trial_cost, trial_folds = _evaluate(assembler, trial_state, everywhere=number % 3 == 0)
        better = (trial_cost < cost) & (trial_folds <= folds) & ~settled
        if observer:
            observer(Iteration(stage, number, float(cost.sum()), float("nan"), float(np.median(damping))))
        gained = better & (cost - trial_cost < SETTLED * cost)
        settled |= gained | (~better & (damping > LARGEST_DAMPING))
        damping = np.where(
            better, np.maximum(0.2 * damping, SMALLEST_DAMPING), 10.0 * np.maximum(damping, 1e-5)
        )
        if better.any():
            state = merged(
                assembler.prepared, at.state, trial.state if trial is not None else at.state, better
            )
            at = assembler.linearize(state, held_locations(assembler.prepared, state.location))
            cost, folds = curve_costs(assembler, at), folded_segments(assembler.prepared, state.coefficients)
        if settled.all():
            break
    return at.state


def _step(assembler: Assembler, at: Linearization, damping: FloatArray) -> State:
    layout = assembler.layout
    diagonal = BlockMatrix(assembler.structure, at.base_values).diagonal()
    curve = np.repeat(layout.node_curve, layout.node_sizes)
    factors = np.where(curve >= 0, damping[curve], 0.0)
    symbolic = assembler.symbolic(at.state)
    values = at.base_values + assembler.stiffness(at)
    for _ in range(12):
        try:
            factor = symbolic.factorize(values, factors * diagonal + 1e-30)
            break
        except NotPositiveDefinite as error:
            own = layout.node_curve[error.node]
            factors = np.where(curve == own, np.maximum(10.0 * factors, 1e-6), factors)
    else:
        return at.state
    reduced = factor.solve(at.base_side) * assembler.mask
    coefficients = reduced[layout.unknown_of_coefficient[:, None] + np.arange(3)]
    return replace(at.state, coefficients=on_shape(assembler.prepared, at.state.coefficients + coefficients))


def _evaluate(
    assembler: Assembler, state: State, *, everywhere: bool
) -> tuple[Linearization | None, FloatArray, IntArray]:
    """Equations, costs and folds at a trial; foot points searched everywhere, or from where they were."""
    folds = folded_segments(assembler.prepared, state.coefficients)
    with np.errstate(all="ignore"):
        moved = (search_locations if everywhere else refine_locations)(assembler.prepared, state)
    try:
        trial = assembler.linearize(moved, held_locations(assembler.prepared, moved.location))
    except FloatingPointError:
        return None, np.full(len(folds), np.inf), folds
    return trial, curve_costs(assembler, trial), folds


def merged(prepared: Prepared, old: State, new: State, better: BoolArray) -> State:
    """New values for the curves that got better, old ones for the others."""
    curves = prepared.curves
    of_coefficient = np.repeat(np.arange(len(curves.bases)), np.diff(curves.coefficient_start))
    measured = prepared.network.curve_observations.curve
    return replace(
        old,
        coefficients=np.where(better[of_coefficient][:, None], new.coefficients, old.coefficients),
        location=np.where(better[measured], new.location, old.location),
    )
