"""Gauss-Newton with Levenberg-Marquardt damping for the network, foot points searched anew at every step.

Every accepted step lowers v'Pv.  The end is an *undamped* step that is negligible: with N d = h its length in units
of the standard deviations of the unknowns is at most sqrt(d'h) (Cauchy-Schwarz), so that sqrt(d'h) bounds the
largest |d_i| / sigma_i.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.estimation.block_cholesky import Factor, NotPositiveDefinite
from splinebba_cli.core.estimation.curve_folding import folded_segments
from splinebba_cli.core.estimation.damping import Damping, curve_costs
from splinebba_cli.core.estimation.elimination import EliminatedPoints
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.locations import held_locations, refine_locations, search_locations
from splinebba_cli.core.result import Iteration
from splinebba_cli.core.state import State

NEGLIGIBLE = 1e-6  # of sigma
STATIONARY = 5e-2  # of sigma, where the cost no longer changes
PIVOT_TOLERANCE = 1e-14
TRIAL_STEPS = 12  # of Newton's method for the foot points
UNCHANGED = 1e-7  # of the cost
CONTRACTING = 0.3  # of the last step: iterations that shrink faster go on
MUCH_WORSE = 1.5
OWN_LIMIT = 1.0  # damping of one curve beyond which it is no longer held back
RESTLESS = 0.1  # of the changes of all curves in the last steps

Observer = Callable[[Iteration], None]


@dataclass(frozen=True)
class Solution:
    """The end of an estimation."""

    linearization: Linearization
    factor: Factor | None  # undamped, at the last state; None where it does not exist
    eliminated: EliminatedPoints | None
    converged: bool
    termination: str
    iterations: tuple[Iteration, ...]
    failed_unknown: int = -1  # reduced unknown at which the undamped factor failed
    restless: tuple[int, ...] = ()  # curves that kept the iterations from settling

    @property
    def state(self) -> State:
        """The adjusted state."""
        return self.linearization.state

    @property
    def held(self) -> IntArray:
        """Measured points whose location is held at its bound."""
        rows = self.linearization.curve
        return rows.point[len(rows.speed) :]


@dataclass(frozen=True)
class _Step:
    state: State
    length: float  # sqrt(d'h)
    predicted: float  # predicted decrease of the cost


def solve(
    assembler: Assembler, state: State, *, max_iterations: int, stage: str, damping: float = 0.0,
    observer: Observer | None = None,
) -> Solution:  # fmt: skip
    """Iterate to convergence.

    Parameters
    ----------
    damping : starting value of the Levenberg-Marquardt factor; 0 begins with Gauss-Newton steps

    Returns
    -------
    Solution
        With `converged` False and the reason in `termination` where the iterations ended otherwise.
    """
    state = search_locations(assembler.prepared, state)
    at = _linearized(assembler, state)
    amount = Damping.starting(assembler, damping)
    log: list[Iteration] = []
    last_decrease, last_length, stiff = np.inf, np.inf, True
    unrest = np.zeros(len(amount.of_curve))
    for number in range(1, max_iterations + 1):
        step, factor, eliminated = _damped_step(assembler, at, amount, stiff)
        if step is None:
            reason = "normal matrix is singular"
            return Solution(at, None, None, False, reason, tuple(log), _failed(assembler, at))
        log.append(Iteration(stage, number, at.cost, step.length, amount.everywhere))
        if observer:
            observer(log[-1])
        stationary = (
            last_decrease <= UNCHANGED * at.cost and CONTRACTING * last_length < step.length <= STATIONARY
        )
        settled, last_length = step.length <= NEGLIGIBLE or stationary, step.length
        if settled and amount.none and stiff:
            stiff = not len(at.curve.stiff.point)
            if stiff is False:
                continue
        if settled and amount.none:
            again = _linearized(assembler, search_locations(assembler.prepared, at.state))
            if again.cost >= at.cost * (1.0 - UNCHANGED) - UNCHANGED * NEGLIGIBLE:
                name = "step negligible" if step.length <= NEGLIGIBLE else "cost stationary"
                return Solution(at, factor, eliminated, True, name, tuple(log))
            at, last_decrease, stiff = again, np.inf, True
            continue
        if settled:
            amount, last_length = Damping.starting(assembler, 0.0), np.inf
            continue
        trial, before = _trial(assembler, step.state, at), curve_costs(assembler, at)
        # along a curve a small step bends: v'Pv may grow by about its own size before it falls
        slack = max(4.0 * step.length**2, UNCHANGED * at.cost) if step.length <= STATIONARY else 0.0
        if trial.at is not None and at.cost - trial.at.cost >= -slack and not _culprits_fold(trial, amount):
            last_decrease = abs(at.cost - trial.at.cost)
            amount = amount.relaxed((at.cost - trial.at.cost) / max(step.predicted, 1e-300))
            at = trial.at
        else:
            amount = amount.raised(_culprits(assembler, at, trial, amount))
            if amount.exhausted:
                break
        if trial.at is not None:
            unrest = 0.8 * unrest + np.abs(curve_costs(assembler, trial.at) - before)
    reason = (
        "no step lowers the residuals"
        if amount.exhausted
        else f"not converged in {max_iterations} iterations"
    )
    restless = tuple(int(k) for k in np.flatnonzero(unrest > RESTLESS * unrest.sum()))
    return Solution(at, None, None, False, reason, tuple(log), restless=restless)


def _linearized(assembler: Assembler, state: State) -> Linearization:
    """Equations at a start.

    Raises
    ------
    FloatingPointError
        Where the approximate values put something behind a camera.
    """
    try:
        return assembler.linearize(state, held_locations(assembler.prepared, state.location))
    except FloatingPointError as error:
        raise FloatingPointError(f"approximate values: {error}") from error


@dataclass(frozen=True)
class _Trial:
    at: Linearization | None  # None where it is impossible
    folds: BoolArray  # (nc,) curves that the step would fold


def _trial(assembler: Assembler, state: State, at: Linearization) -> _Trial:
    """Equations at a trial state with foot points refined."""
    prepared = assembler.prepared
    before = folded_segments(prepared, at.state.coefficients)
    folds: BoolArray = folded_segments(prepared, state.coefficients) > before
    with np.errstate(all="ignore"):
        moved = refine_locations(prepared, state, TRIAL_STEPS)
    if not np.isfinite(moved.location).all():
        return _Trial(None, folds)
    try:
        return _Trial(assembler.linearize(moved, held_locations(prepared, moved.location)), folds)
    except FloatingPointError:
        return _Trial(None, folds)


def _culprits_fold(trial: _Trial, amount: Damping) -> bool:
    """Whether a step folds a curve that damping of its own may still keep from it."""
    return bool((trial.folds & (amount.of_curve < OWN_LIMIT)).any())


def _culprits(assembler: Assembler, at: Linearization, trial: _Trial, amount: Damping) -> BoolArray:
    """Curves that spoil a trial and are not yet held by damping of their own: folding, or much worse residuals."""
    spoilt = trial.folds.copy()
    if trial.at is not None:
        before, after = curve_costs(assembler, at), curve_costs(assembler, trial.at)
        spoilt |= after > MUCH_WORSE * before + MUCH_WORSE
    return np.asarray(spoilt & (amount.of_curve < OWN_LIMIT))


def _damped_step(
    assembler: Assembler, at: Linearization, amount: Damping, stiff: bool
) -> tuple[_Step | None, Factor | None, EliminatedPoints | None]:
    """A step with the given damping; None where the normal matrix stays indefinite.

    Where the undamped matrix is not positive definite, `amount` is raised in place until it is.
    """
    symbolic = assembler.symbolic(at.state)
    while not amount.exhausted:
        try:
            values, side, eliminated = assembler.eliminate(at, amount.everywhere)
            if stiff:
                values += assembler.stiffness(at)
            extra = amount.of_unknowns(assembler, at)
            factor = symbolic.factorize(values, extra, pivot_tolerance=PIVOT_TOLERANCE)
        except (NotPositiveDefinite, np.linalg.LinAlgError):
            amount.everywhere = max(10.0 * amount.everywhere, 1e-8)
            continue
        reduced = factor.solve(side) * assembler.mask
        points = _point_step(assembler, eliminated, reduced)
        predicted = float(side @ reduced)
        predicted += float(
            np.einsum("ni,nij,nj->", eliminated.right_side, eliminated.inverse, eliminated.right_side)
        )
        moved = apply_step(assembler, at.state, reduced, points)
        return _Step(moved, float(np.sqrt(max(predicted, 0.0))), predicted), factor, eliminated
    return None, None, None


def _failed(assembler: Assembler, at: Linearization) -> int:
    """Reduced unknown at which the undamped factorisation fails, -1 where it does not."""
    try:
        values, _, _ = assembler.eliminate(at, 0.0)
        assembler.symbolic(at.state).factorize(values, pivot_tolerance=PIVOT_TOLERANCE)
    except NotPositiveDefinite as error:
        return int(assembler.layout.node_starts[error.node] + error.unknown_in_node)
    except np.linalg.LinAlgError:
        return -1
    return -1


def _point_step(assembler: Assembler, eliminated: EliminatedPoints, reduced: FloatArray) -> FloatArray:
    """Steps of the points: H^-1 (h_x - sum W'd)."""
    observed = assembler.prepared.network.point_observations
    side = eliminated.right_side.copy()
    if len(observed):
        orientation = reduced[: assembler.layout.image_mask.size].reshape(-1, 6)[observed.image]
        np.subtract.at(side, observed.point, np.matmul(orientation[:, None, :], eliminated.coupling)[:, 0])
    return np.asarray(np.matmul(eliminated.inverse, side[:, :, None])[:, :, 0] * assembler.layout.point_mask)


def apply_step(assembler: Assembler, state: State, reduced: FloatArray, points: FloatArray) -> State:
    """The state after a step of the reduced unknowns (N,) and the points (n, 3); locations unchanged."""
    layout = assembler.layout
    images = reduced[: layout.image_mask.size].reshape(-1, 6)
    coefficients = reduced[layout.unknown_of_coefficient[:, None] + np.arange(3)]
    return replace(
        state,
        rotation=state.rotation @ rotation_from_vector(images[:, :3]),
        position=state.position + images[:, 3:],
        coefficients=state.coefficients + coefficients,
        xyz=state.xyz + points,
    )
