"""The observations whose undetected errors do most harm, with what an error of one MDB does (external reliability).

    d = Q a' delta0 / sqrt(r),    on the orientation of image i in its sigmas: sqrt(d_i' Q_ii^-1 d_i)

Candidates come from the figures that every observation has (reliability.py); only theirs are solved for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.evidence import Influence, ObservationKind
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.object_effects import ObjectEffects
from splinebba_cli.core.quality.observation_effects import Effects, EquationColumns, ObservationEffects
from splinebba_cli.core.quality.observation_names import curve_point_name, distance_name, image_point_name
from splinebba_cli.core.quality.prior_residuals import AXES, EOP_NAMES
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.reliability import CONTROLLED
from splinebba_cli.core.result import ResidualTable

MOST = 20
BLOCK_ENTRIES = 16_000_000  # of the right-hand sides that are solved together


@dataclass(frozen=True)
class _Candidates:
    """Observations of one kind and their equations."""

    kind: ObservationKind
    unit: Literal["mm", "rad", "m"]
    columns: Callable[[slice], EquationColumns]  # of some of them
    redundancy: FloatArray  # (q,)
    sigma: FloatArray  # (q,)
    names: list[str]


def influences(
    cofactors: Cofactors,
    solved: ConditionedSolution,
    numbers: RedundancyNumbers,
    curves: ResidualTable,
    points: ResidualTable,
    delta0: float,
) -> tuple[Influence, ...]:
    """The most influential observations, those that bend an orientation most first.

    Parameters
    ----------
    curves, points : residual tables of image points
    delta0 : noncentrality of the tests
    """
    effects_of = ObservationEffects(solved.assembler, solved.solution)
    weights = cofactors.orientation_weights
    on_objects = ObjectEffects.of(solved.assembler.prepared, solved.solution.state)
    found: list[Influence] = []
    width = max(1, BLOCK_ENTRIES // int(solved.assembler.layout.node_starts[-1]))
    for part in _candidates(effects_of, solved, numbers, curves, points):
        for begin in range(0, len(part.names), width):
            own = slice(begin, begin + width)
            errors = delta0 / np.sqrt(part.redundancy[own])
            effects = effects_of.of(part.columns(own), errors)
            if cofactors.datum is not None:
                effects = cofactors.datum.of_effects(effects)
            least = found[-1].orientation if len(found) == MOST else 0.0
            found += _described(part, own, errors, effects, weights, on_objects, least)
            found.sort(
                key=lambda influence: (-influence.orientation, -influence.bias_to_noise, influence.name)
            )
            found = found[:MOST]
    return tuple(found)


def _candidates(
    effects: ObservationEffects,
    solved: ConditionedSolution,
    numbers: RedundancyNumbers,
    on_curves: ResidualTable,
    on_points: ResidualTable,
) -> Iterator[_Candidates]:
    network = solved.assembler.prepared.network
    seen, points = network.curve_observations, network.point_observations
    rows = _largest(_harm(on_curves)[:, 0])
    if len(rows):
        sigma = np.linalg.norm(numbers.curve.normal[rows] * seen.sigma[rows], axis=1)
        names = [f"{curve_point_name(network, k)}, across" for k in rows]
        yield _Candidates(
            "spline",
            "mm",
            lambda part: effects.curve_rows(rows[part]),
            numbers.curve_rows[rows],
            sigma,
            names,
        )
    flat = _largest(_harm(on_points).ravel())
    if len(flat):
        rows, axis = flat // 2, flat % 2
        names = [f"{image_point_name(network, k)}, {'xy'[d]}" for k, d in zip(rows, axis, strict=True)]
        yield _Candidates(
            "point", "mm", lambda part: effects.image_points(rows[part], axis[part]), numbers.image_points[rows, axis],
            points.sigma[rows, axis], names,
        )  # fmt: skip
    yield from _priors(effects, solved, numbers)


def _priors(
    effects: ObservationEffects, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> Iterator[_Candidates]:
    """Control coordinates, given values of curves, prior orientations: the least controlled of every kind."""
    network, at = solved.assembler.prepared.network, solved.solution.linearization
    weighted = numbers.point_priors * (solved.assembler.point_inverse_sigma > 0.0)
    flat = _largest(-np.where(weighted > CONTROLLED, weighted, np.inf).ravel())
    if len(flat):
        point, axis = flat // 3, flat % 3
        names = [
            f"control point `{network.points.ids[k]}`, {AXES[d]}" for k, d in zip(point, axis, strict=True)
        ]
        yield _Candidates(
            "control point", "m", lambda part: effects.point_priors(point[part], axis[part]),
            numbers.point_priors[point, axis], network.points.sigma[point, axis], names,
        )  # fmt: skip
    distances = _largest(-np.where(numbers.distances > CONTROLLED, numbers.distances, np.inf))
    if len(distances):
        names = [distance_name(network, int(k)) for k in distances]
        yield _Candidates(
            "distance", "m", lambda part: effects.distances(distances[part]), numbers.distances[distances],
            network.distances.sigma[distances], names,
        )  # fmt: skip
    rows = solved.assembler.coefficient_rows
    given = np.where(
        (rows.component < GAUGE) & (numbers.coefficient_rows > CONTROLLED), numbers.coefficient_rows, np.inf
    )
    chosen = _largest(-given)
    if len(chosen):
        names = [
            f"control spline `{network.curves[rows.curve[k]].id}`, knot {rows.row[k]} {AXES[rows.component[k]]}"
            for k in chosen
        ]
        yield _Candidates(
            "control spline", "m", lambda part: effects.coefficient_rows(chosen[part]),
            numbers.coefficient_rows[chosen], rows.sigma[chosen], names,
        )  # fmt: skip
    yield from _orientations(
        effects, at.orientation_priors.image, numbers, network.images.ids, network.images.prior_sigma
    )


def _orientations(
    effects: ObservationEffects,
    image: IntArray,
    numbers: RedundancyNumbers,
    ids: tuple[str, ...],
    sigma: FloatArray,
) -> Iterator[_Candidates]:
    flat = _largest(
        -np.where(numbers.orientation_priors > CONTROLLED, numbers.orientation_priors, np.inf).ravel()
    )
    units: tuple[tuple[Literal["rad", "m"], IntArray], ...] = (
        ("rad", flat[flat % 6 < 3]),
        ("m", flat[flat % 6 >= 3]),
    )
    for unit, part in units:
        if len(part):
            rows, component = part // 6, part % 6
            names = [
                f"prior orientation of image `{ids[image[k]]}`, {EOP_NAMES[c]}"
                for k, c in zip(rows, component, strict=True)
            ]
            yield _Candidates(
                "eop prior", unit, partial(_prior_columns, effects, rows, component),
                numbers.orientation_priors[rows, component], sigma[image[rows], component], names,
            )  # fmt: skip


def _harm(table: ResidualTable) -> FloatArray:
    """Effect on the orientation, or on any unknown where orientations are fixed; NaN where no error is ever found."""
    found = table.reliability.orientation_influence
    if not (found > 0.0).any():
        found = table.reliability.bias_to_noise
    return np.where(table.redundancy > CONTROLLED, found, np.nan)


def _largest(figures: FloatArray) -> IntArray:
    """Numbers of the largest finite figures, largest first."""
    finite = np.flatnonzero(np.isfinite(figures))
    if len(finite) > MOST:
        last = len(finite) - MOST
        finite = finite[figures[finite] >= np.partition(figures[finite], last)[last]]
    order = np.argsort(-figures[finite], kind="stable")[:MOST]
    return np.asarray(finite[order], dtype=np.int64)


def _prior_columns(
    effects: ObservationEffects, rows: IntArray, component: IntArray, part: slice
) -> EquationColumns:
    return effects.orientation_priors(rows[part], component[part])


def _described(
    part: _Candidates,
    own: slice,
    errors: FloatArray,
    effects: Effects,
    weights: FloatArray,
    on_objects: ObjectEffects,
    least: float,
) -> list[Influence]:
    """Some of a part, those that bend an orientation by at least so much."""
    images, found = on_objects.network.images.ids, []
    columns = (part.names[own], part.redundancy[own].tolist(), part.sigma[own].tolist())
    for k, (name, r, sigma) in enumerate(zip(*columns, strict=True)):
        moved = effects.orientation[:, :, k]
        square = np.sum(np.matmul(moved[:, None], weights)[:, 0] * moved, axis=1)
        on_orientation = np.sqrt(np.maximum(square, 0.0))
        if on_orientation.max() < least:
            continue
        position = np.linalg.norm(moved[:, 3:], axis=1)
        angle = np.linalg.norm(moved[:, :3], axis=1)
        worst = [int(np.argmax(figures)) for figures in (on_orientation, position, angle)]
        size, subject = on_objects.largest(effects.point[:, :, k], effects.coefficients[:, :, k])
        found.append(
            Influence(
                kind=part.kind,
                name=name,
                redundancy=r,
                minimal_detectable_bias=float(errors[k] * sigma),
                unit=part.unit,
                bias_to_noise=float(errors[k] * np.sqrt(max(1.0 - r, 0.0))),
                orientation=float(on_orientation[worst[0]]),
                orientation_image=images[worst[0]],
                position_m=float(position[worst[1]]),
                position_image=images[worst[1]],
                angle_rad=float(angle[worst[2]]),
                angle_image=images[worst[2]],
                object_m=size,
                object_name=subject,
            )
        )
    return found
