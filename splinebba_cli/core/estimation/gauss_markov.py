"""Gauss-Newton with Levenberg-Marquardt damping for the network, foot points searched anew at every step.

Every accepted step lowers v'Pv.  The end is an *undamped* step that is negligible: with N d = h its length in units
of the standard deviations of the unknowns is at most sqrt(d'h) (Cauchy-Schwarz), so that sqrt(d'h) bounds the
largest |d_i| / sigma_i.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.core.estimation.block_cholesky import Factor, NotPositiveDefinite
from splinebba_cli.core.estimation.curve_folding import folding_segments
from splinebba_cli.core.estimation.damping import Damping
from splinebba_cli.core.estimation.elimination import EliminatedPoints
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.simplified_steps import (
    LONGEST,
    MOST,
    applicable,
    lengths_left,
    simplified_step,
)
from splinebba_cli.core.estimation.stretches import Stretches, stretch_costs
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations, refine_locations
from splinebba_cli.core.result import Iteration
from splinebba_cli.core.state import State, on_shape

VANISHING = 1e-6  # of sigma
NEGLIGIBLE = 2e-3  # of the estimated sigma, for the worst of all functions of the unknowns
RAPID = 0.02  # of the last step: shrinking faster, one more iteration brings many digits
STATIONARY = 5e-2  # of sigma, where the cost no longer changes
PIVOT_TOLERANCE = 1e-14
TRIAL_STEPS = 12  # of Newton's method for the foot points
UNCHANGED = 1e-7  # of the cost
CONTRACTING = 0.3  # of the last step: iterations that shrink faster go on
MUCH_WORSE = 1.5
SAME_LOCATION = 1e-8  # of its value
MUCH_OF_IT = 0.1  # of what all stretches got worse together
OWN_LIMIT = 1.0  # damping of one stretch beyond which it is no longer held back
FORGETTING = 0.8  # per step
PLAIN_TRIES = 2  # damping off, second-order part off
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
    restless: tuple[int, ...] = ()  # curves that kept the iterations from settling
    unrest: FloatArray = field(default_factory=lambda: np.zeros(0))  # (s,) recent changes of every stretch

    @property
    def state(self) -> State:
        """The adjusted state."""
        return self.linearization.state

    @property
    def held(self) -> IntArray:
        """Measured points whose location is held at its bound."""
        return self.linearization.held


@dataclass(frozen=True)
class _Step:
    state: State
    length: float  # sqrt(d'h)
    predicted: float  # predicted decrease of the cost
    factor: Factor
    eliminated: EliminatedPoints


def solve(
    assembler: Assembler, state: State, *, max_iterations: int, stage: str, damping: float = 0.0,
    observer: Observer | None = None, stationary: float = STATIONARY,
) -> Solution:  # fmt: skip
    """Iterate to convergence.

    Parameters
    ----------
    damping : starting value of the Levenberg-Marquardt factor; 0 begins with Gauss-Newton steps
    stationary : length of a step, in sigma, below which a cost that no longer changes ends the iterations

    Returns
    -------
    Solution
        With `converged` False and the reason in `termination` where the iterations ended otherwise.
    """
    run = _Run(assembler, stage, observer, Damping.starting(assembler, damping), damping > 0.0, stationary)
    with one_thread():
        return _iterated(run, state, max_iterations)


def _iterated(run: _Run, state: State, max_iterations: int) -> Solution:
    """Iterations from a state."""
    assembler = run.assembler
    at = _linearized(assembler, search_locations(assembler.prepared, state))
    step: _Step | None = None
    for _ in range(max_iterations):
        step = None  # its factor makes room for the next one
        step = run.step_from(at)
        if step is None:
            reason = "normal matrix is singular"
            return Solution(at, None, None, False, reason, tuple(run.log))
        if not run.settled(step, at):
            at = run.advanced(at, run.simplified(step, at))
        elif not run.plain:
            if run.made_plain > PLAIN_TRIES:
                return run.ended_damped(at)
            run.make_plain()
        else:
            again = _searched_again(assembler, at)
            if again is at or again.cost >= at.cost * (1.0 - UNCHANGED) - UNCHANGED * VANISHING:
                name = "step negligible" if run.negligible(step, at) else "cost stationary"
                return Solution(at, step.factor, step.eliminated, True, name, tuple(run.log))
            at, run.last_decrease = again, np.inf
        if run.damping.exhausted:
            break
    exhausted = run.damping.exhausted
    reason = "no step lowers the residuals" if exhausted else f"not converged in {max_iterations} iterations"
    return Solution(at, None, None, False, reason, tuple(run.log), restless=run.restless, unrest=run.unrest)


def solution_at(assembler: Assembler, state: State) -> Solution:
    """Equations and factor at a state that is known to be a solution; not converged where the matrix is singular.

    Raises
    ------
    FloatingPointError
        If the state puts something behind a camera.
    """
    at = _linearized(assembler, search_locations(assembler.prepared, state))
    step = _damped_step(assembler, at, Damping.starting(assembler, 0.0), stiff=False)
    if step is None:
        return Solution(at, None, None, False, "normal matrix is singular", ())
    return Solution(at, step.factor, step.eliminated, True, "known solution", ())


@dataclass
class _Run:
    """The changing part of the iterations: damping, and what the last steps did."""

    assembler: Assembler
    stage: str
    observer: Observer | None
    damping: Damping
    stiff: bool  # whether steps take the second-order part of the locations: from the first rejected step on
    stationary: float = STATIONARY
    log: list[Iteration] = field(default_factory=list)
    made_plain: int = 0  # attempts at this state
    last_decrease: float = np.inf
    last_length: float = np.inf
    unrest: FloatArray = field(default_factory=lambda: np.zeros(0))  # (s,) of the residuals of every stretch

    @property
    def plain(self) -> bool:
        """Whether the step is the undamped one of the normal equations."""
        return self.damping.none and not self.stiff

    @property
    def restless(self) -> tuple[int, ...]:
        """Curves that keep the iterations from settling."""
        stretches = Stretches.of(self.assembler.layout, self.assembler.prepared.curves)
        if not len(self.unrest):
            return ()
        unrest = np.bincount(stretches.curve, self.unrest)
        return tuple(int(k) for k in np.flatnonzero(unrest > RESTLESS * unrest.sum()))

    def step_from(self, at: Linearization) -> _Step | None:
        """The next step; None where the normal matrix is singular."""
        step = _damped_step(self.assembler, at, self.damping, self.stiff)
        if step is not None:
            self._record(at.cost, step.length)
        return step

    def _record(self, cost: float, length: float) -> None:
        self.log.append(Iteration(self.stage, len(self.log) + 1, cost, length, self.damping.everywhere))
        if self.observer:
            self.observer(self.log[-1])

    def settled(self, step: _Step, at: Linearization) -> bool:
        """Whether a step is negligible, or small while neither it nor the cost shrinks any more."""
        contracting = step.length <= CONTRACTING * self.last_length
        rapid = bool(np.isfinite(self.last_length)) and step.length <= RAPID * self.last_length
        stationary = (
            self.last_decrease <= UNCHANGED * at.cost and step.length <= self.stationary and not contracting
        )
        self.last_length = step.length
        return step.length <= VANISHING or (self.negligible(step, at) and not rapid) or stationary

    def negligible(self, step: _Step, at: Linearization) -> bool:
        """Whether no function of the unknowns changes by a share of its standard deviation that counts."""
        return step.length <= max(VANISHING, NEGLIGIBLE * min(1.0, self.assembler.deviation(at)))

    def make_plain(self) -> None:
        """Take off the damping first, then the second-order part."""
        self.made_plain += 1
        if self.damping.none:
            self.stiff = False
        else:
            self.damping, self.last_length = Damping.starting(self.assembler, 0.0), np.inf

    def ended_damped(self, at: Linearization) -> Solution:
        """The end where damped steps no longer lower the cost, and no undamped one is taken.

        It is a solution all the same where the undamped step is so small that a stationary cost ends the iterations:
        foot points beside kinks of a curve make v'Pv bend within less than that.
        """
        undamped = Damping.starting(self.assembler, 0.0)
        step = _damped_step(self.assembler, at, undamped, stiff=False)
        if step is None or not undamped.none:
            return Solution(at, None, None, False, "normal matrix is singular", tuple(self.log))
        if step.length > self.stationary:
            return Solution(at, None, None, False, "no undamped step lowers the residuals", tuple(self.log))
        return Solution(at, step.factor, step.eliminated, True, "cost stationary", tuple(self.log))

    def simplified(self, step: _Step, at: Linearization) -> _Step:
        """The step and, near the solution, more of them with the same factor while they contract."""
        if not (self.plain and step.length <= LONGEST and applicable(self.assembler)):
            return step
        state, last = step.state, step.length
        for _ in range(MOST):
            state = refine_locations(self.assembler.prepared, state, TRIAL_STEPS)
            more = simplified_step(self.assembler, step.factor, state)
            if more is None or not more.length <= CONTRACTING * last:
                break
            self._record(more.cost, more.length)
            state = apply_step(self.assembler, state, more.reduced, np.zeros_like(state.xyz))
            left, last = lengths_left(more.length, last), more.length
            if left <= NEGLIGIBLE * min(1.0, self.assembler.deviation(at)):
                break
        self.last_length = last
        return replace(step, state=state)

    def advanced(self, at: Linearization, step: _Step) -> Linearization:
        """The equations after an accepted step, or the same with more damping after a rejected one."""
        trial = _trial(self.assembler, step.state, at)
        if trial.at is not None:
            change = np.abs(trial.costs[1] - trial.costs[0])
            self.unrest = FORGETTING * self.unrest + change if len(self.unrest) else change
        # along a curve a small step bends: v'Pv may grow by about its own size before it falls
        slack = max(4.0 * step.length**2, UNCHANGED * at.cost) if step.length <= STATIONARY else 0.0
        if trial.at is None or at.cost - trial.at.cost < -slack or _folds(trial, self.damping):
            self.damping, self.stiff = self.damping.raised(_culprits(trial, self.damping)), True
            return at
        self.made_plain = 0
        decrease = at.cost - trial.at.cost
        self.last_decrease = abs(decrease)
        self.damping = self.damping.relaxed(decrease / max(step.predicted, 1e-300))
        return trial.at


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


def _searched_again(assembler: Assembler, at: Linearization) -> Linearization:
    """Equations with all foot points searched globally; the same ones where none moves."""
    state = search_locations(assembler.prepared, at.state)
    moved = np.abs(state.location - at.state.location) > SAME_LOCATION * np.abs(at.state.location)
    return _linearized(assembler, state) if moved.any() else at


@dataclass(frozen=True)
class _Trial:
    at: Linearization | None  # None where it is impossible
    folds: BoolArray  # (s,) stretches that the step would fold
    stretches: Stretches
    costs: tuple[FloatArray, FloatArray]  # (s,) of every stretch before and after, where it is possible


def _trial(assembler: Assembler, state: State, at: Linearization) -> _Trial:
    """Equations at a trial state with foot points refined."""
    prepared = assembler.prepared
    stretches = Stretches.of(assembler.layout, prepared.curves)
    count, of_segments = len(stretches.curve), stretches.of_segments()
    before, after = (
        np.bincount(of_segments[folding_segments(prepared, x)], minlength=count)
        for x in (at.state.coefficients, state.coefficients)
    )
    folds = stretches.with_neighbours(after > before)
    impossible = _Trial(None, folds, stretches, (np.zeros(count), np.zeros(count)))
    with np.errstate(all="ignore"):
        moved = refine_locations(prepared, state, TRIAL_STEPS)
    if not np.isfinite(moved.location).all():
        return impossible
    try:
        trial = assembler.linearize(moved, held_locations(prepared, moved.location))
    except FloatingPointError:
        return impossible
    return _Trial(trial, folds, stretches, stretch_costs(assembler, stretches, at, trial))


def _folds(trial: _Trial, amount: Damping) -> bool:
    """Whether a step folds a curve that damping of its own may still keep from it."""
    return bool((trial.folds & (amount.of_stretch < OWN_LIMIT)).any())


def _culprits(trial: _Trial, amount: Damping) -> BoolArray:
    """Stretches that spoil a trial and are not yet held by damping of their own: folding, or much worse residuals.

    Of a long curve also those that are only somewhat worse themselves but make much of what all got worse.
    """
    before, after = trial.costs
    growth = np.maximum(after - before, 0.0)
    spoilt = after > MUCH_WORSE * before + MUCH_WORSE
    spoilt |= ~trial.stretches.whole & (growth > MUCH_OF_IT * growth.sum())
    spoilt = trial.folds | trial.stretches.with_neighbours(spoilt)
    return np.asarray(spoilt & (amount.of_stretch < OWN_LIMIT))


def _damped_step(assembler: Assembler, at: Linearization, amount: Damping, stiff: bool) -> _Step | None:
    """A step with the given damping; None where the normal matrix stays indefinite.

    Where the undamped matrix is not positive definite, `amount` is raised in place until it is.
    """
    symbolic = assembler.symbolic(at.state)
    while not amount.exhausted:
        try:
            values, side, eliminated = assembler.eliminate(at, amount.everywhere)
            if stiff:
                values = values + assembler.stiffness(at)
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
        return _Step(moved, float(np.sqrt(max(predicted, 0.0))), predicted, factor, eliminated)
    return None


def _point_step(assembler: Assembler, eliminated: EliminatedPoints, reduced: FloatArray) -> FloatArray:
    """Steps of the points: H^-1 (h_x - sum W'd), or those of the reduced system."""
    observed = assembler.prepared.network.point_observations
    side = eliminated.right_side.copy()
    if len(assembler.pairs.a):
        orientation = reduced[: assembler.layout.image_mask.size].reshape(-1, 6)[observed.image]
        np.subtract.at(side, observed.point, np.matmul(orientation[:, None, :], eliminated.coupling)[:, 0])
    layout = assembler.layout
    step = np.matmul(eliminated.inverse, side[:, :, None])[:, :, 0] * layout.eliminated_mask
    kept = layout.kept_points
    step[kept] = reduced[layout.unknown_of_point[kept]]
    return np.asarray(step)


def apply_step(assembler: Assembler, state: State, reduced: FloatArray, points: FloatArray) -> State:
    """The state after a step of the reduced unknowns (N,) and the points (n, 3); locations unchanged."""
    layout = assembler.layout
    images = reduced[: layout.image_mask.size].reshape(-1, 6)
    coefficients = reduced[layout.unknown_of_coefficient[:, None] + np.arange(3)]
    return replace(
        state,
        rotation=state.rotation @ rotation_from_vector(images[:, :3]),
        position=state.position + images[:, 3:],
        coefficients=on_shape(assembler.prepared, state.coefficients + coefficients),
        xyz=state.xyz + points,
    )
