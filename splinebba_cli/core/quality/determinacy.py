"""Refuse what is no solution: singular, not converged, or determined on paper only.

A position whose standard deviation reaches a fifth of its distance to the object, or an angle of a fifth of a
radian, is outside of any linearisation: figures computed there mean nothing, and the direction is named instead.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.design_matrix import design_matrix
from splinebba_cli.core.estimation.gauss_markov import Solution
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.null_names import ORIENTATION
from splinebba_cli.core.estimation.numerical_rank import rounding_limit, scaled_columns
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.estimation.rank_diagnosis import null_space
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.null_problems import null_problems
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared
from splinebba_cli.errors import NotConvergedError, SingularNetworkError

MEANINGLESS = 0.2
MORE_CONTROL = (
    "measure more control or tie features in it, spread over the format and in height, "
    "or give a prior orientation (GNSS/INS)"
)
EARLY_LIMIT = 500  # unknowns up to which the rank is looked at before the iterations


def require_determined(prepared: Prepared, solved: ConditionedSolution) -> None:
    """Check a joint solution.

    Raises
    ------
    SingularNetworkError, NotConvergedError
    """
    solution = solved.solution
    if solution.factor is None:
        problems = _null_problems(prepared, solved)
        if problems:
            raise SingularNetworkError(problems)
    if not solution.converged:
        weak = weak_images(prepared, solved) or _weak_by_design(prepared, solved)
        raise NotConvergedError([*weak, _not_converged(prepared, solution)])
    weak = weak_images(prepared, solved)
    if weak:
        raise SingularNetworkError(weak)


def rank_is_looked_at(layout: ParameterLayout) -> bool:
    """Whether a network is small enough for a dense look at its rank."""
    return layout.free_count <= EARLY_LIMIT


def require_rank(assembler: Assembler, at: Linearization) -> None:
    """Refuse a network (small: EARLY_LIMIT) that is singular at its approximate values, before any iteration.

    Raises
    ------
    SingularNetworkError
        Naming the null directions of all equations, conditions included.
    """
    if not rank_is_looked_at(assembler.layout):
        return
    problems = null_problems(null_space(assembler, at), assembler.layout, assembler.prepared.network)
    if problems:
        raise SingularNetworkError(problems)


def _not_converged(prepared: Prepared, solution: Solution) -> Problem:
    curves = prepared.network.curves
    free = [curves[k] for k in solution.restless if not (curves[k].sigma == 0.0).all()]
    names = ", ".join(f"`{curve.id}`" for curve in free)
    named = f"splines {names} keep" if len(free) > 1 else f"spline {names} keeps"
    return Problem(
        "SBB502",
        "error",
        f"the adjustment did not converge: {solution.termination}"
        + (f"; {named} it from settling" if names else ""),
        "adjustment",
        "choose other knots for these splines (`adjustment: {knots: {spacing_m: …, insert: true, drop: true}}`)"
        if names
        else "check approximate values and units; look for gross errors; raise adjustment.max_iterations",
    )


def _null_problems(prepared: Prepared, solved: ConditionedSolution) -> tuple[Problem, ...]:
    null = null_space(solved.assembler, solved.solution.linearization)
    return null_problems(null, solved.assembler.layout, prepared.network)


def object_distance(prepared: Prepared, solved: ConditionedSolution) -> FloatArray:
    """Mean distance of every image to what it sees, (m,) metres; NaN where it sees nothing."""
    state, network = solved.solution.state, prepared.network
    count = len(network.images.ids)
    image: IntArray = np.concatenate([network.point_observations.image, network.curve_observations.image])
    seen = state.xyz[network.point_observations.point]
    on_curves = prepared.curves.evaluate(
        state.coefficients, network.curve_observations.curve, state.location
    )[0]
    distance = np.linalg.norm(np.vstack([seen, on_curves]) - state.position[image], axis=1)
    rays = np.bincount(image, minlength=count)
    total = np.bincount(image, distance, minlength=count)
    return np.where(rays > 0, total / np.maximum(rays, 1), np.nan)


def _weak_by_design(prepared: Prepared, solved: ConditionedSolution) -> list[Problem]:
    """Images that no solution of a small network could determine: from its design, where there is no factor."""
    assembler, at = solved.assembler, solved.solution.linearization
    if not rank_is_looked_at(assembler.layout):
        return []
    sigma = _design_sigma(assembler, at)
    return [
        Problem(
            "SBB522",
            "error",
            f"image `{prepared.network.images.ids[image]}` is determined on paper only, "
            f"σ of its position = {_length(float(sigma[image, 3:].max()))}",
            f"image `{prepared.network.images.ids[image]}`",
            MORE_CONTROL,
        )
        for image in _meaningless(sigma, object_distance(prepared, solved))
    ]


def _design_sigma(assembler: Assembler, at: Linearization) -> FloatArray:
    """A priori standard deviations (m, 6) of (theta, X0) from the singular values of the design."""
    made = design_matrix(assembler, at)
    scaled, _ = scaled_columns(made.matrix)
    _, singular, right = np.linalg.svd(scaled, full_matrices=False)
    singular = np.maximum(singular, rounding_limit(scaled.shape[1]) * singular[0])
    norm = np.linalg.norm(made.matrix, axis=0)
    own = np.linalg.norm(right / singular[:, None], axis=0) / np.where(norm > 0.0, norm, 1.0)
    sigma = np.zeros(assembler.layout.image_mask.size)
    of_images = made.unknown < len(sigma)
    sigma[made.unknown[of_images]] = own[of_images]
    return sigma.reshape(-1, 6)


def _meaningless(sigma: FloatArray, distance: FloatArray) -> IntArray:
    """Images whose standard deviations are outside of any linearisation."""
    far = (sigma[:, 3:].max(axis=1) > MEANINGLESS * distance) | (sigma[:, :3].max(axis=1) > MEANINGLESS)
    return np.flatnonzero(far)


def weak_images(prepared: Prepared, solved: ConditionedSolution) -> list[Problem]:
    """Images of a solution that are determined on paper only, none where there is no factor."""
    solution = solved.solution
    if solution.factor is None:
        return []
    diagonal = solution.factor.selected_inverse().diagonal()[: solved.assembler.layout.image_mask.size]
    sigma = np.sqrt(np.maximum(diagonal, 0.0)).reshape(-1, 6) * solved.assembler.layout.image_mask
    problems = []
    for image in _meaningless(sigma, object_distance(prepared, solved)):
        id_ = prepared.network.images.ids[image]
        names = _inseparable(prepared, solved, int(image))
        worst = float(sigma[image, 3:].max())
        problems.append(
            Problem(
                "SBB522",
                "error",
                f"image `{id_}`: {names} are not separable by its measurements, σ of its position = {_length(worst)}",
                f"image `{id_}`",
                MORE_CONTROL,
            )
        )
    return problems


def _inseparable(prepared: Prepared, solved: ConditionedSolution, image: int) -> str:
    """The angle and the coordinate of an image with the highest correlation."""
    factor, state = solved.solution.factor, solved.solution.state
    if factor is None:
        return "its unknowns"
    block = np.asarray(factor.selected_inverse().blocks([image], [image]))[0]
    transform = eop_transform(prepared.network.images, state.rotation)[image]
    block = transform @ block @ transform.T
    root = np.sqrt(np.maximum(np.diag(block), 1e-300))
    correlation = np.abs(block / np.outer(root, root))[:3, 3:]
    angle, position = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    return f"{ORIENTATION[angle]} and {ORIENTATION[3 + position]}"


def _length(metres: float) -> str:
    return f"{metres / 1000:.3g} km" if metres >= 1000 else f"{metres:.3g} m"
