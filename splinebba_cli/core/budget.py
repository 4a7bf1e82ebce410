"""The redundancy budget of a network before its adjustment: counts, rank, and who is weak.

Equations and unknowns of the measurements and priors alone, before gauge and datum conditions: a measured curve
point brings two equations and one location.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.counts import count_equations
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.estimation.rank_diagnosis import null_space
from splinebba_cli.core.network import IntArray, Network
from splinebba_cli.core.observations.locations import held_locations, search_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.quality.null_problems import null_problems
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import prepare


@dataclass(frozen=True)
class FeatureBudget:
    """Counts of one curve or point."""

    kind: str  # "spline" or "point"
    id: str
    images: int
    observations: int  # measured image points
    equations: int
    unknowns: int  # coefficients or coordinates, and locations


@dataclass(frozen=True)
class ImageBudget:
    """Counts of one image."""

    id: str
    spline_points: int
    points: int
    splines: int
    equations: int


@dataclass(frozen=True)
class Budget:
    """Counts of the whole network, of the measurements and priors alone."""

    equations: int
    unknowns: int
    rank: int
    nullity: int
    redundancy: int  # equations - rank
    features: tuple[FeatureBudget, ...]
    images: tuple[ImageBudget, ...]
    problems: tuple[Problem, ...]


def budget(network: Network) -> Budget:
    """Count and rank at the approximate values.

    Raises
    ------
    NotSolvableError
        If there are no approximate values to count at.
    """
    prepared = prepare(network)
    state, problems = starting_state(prepared)
    state = search_locations(prepared, state)
    layout = layout_of(prepared)
    assembler = Assembler(prepared, layout, control_rows(prepared, layout.coefficient_mask))
    held = held_locations(prepared, state.location)
    at = assembler.linearize(state, held)
    equations = count_equations(assembler, at)
    locations = len(network.curve_observations) - len(held)
    null = null_space(assembler, at)
    unknowns, rank = null.unknowns + locations, null.rank + locations
    named = null_problems(null, layout, network)
    return Budget(
        equations, unknowns, rank, unknowns - rank, equations - rank,
        _features(network, assembler, held), _images(network), (*problems, *named),
    )  # fmt: skip


def _features(network: Network, assembler: Assembler, held: IntArray) -> tuple[FeatureBudget, ...]:
    observed, layout = network.curve_observations, assembler.layout
    curves = assembler.prepared.curves
    held_of = np.bincount(observed.curve[held], minlength=len(network.curves))
    count = np.bincount(observed.curve, minlength=len(network.curves))
    features = []
    for k, curve in enumerate(network.curves):
        rows = slice(int(curves.coefficient_start[k]), int(curves.coefficient_start[k + 1]))
        free = int(layout.coefficient_mask[rows].sum())
        seen = len(np.unique(observed.image[observed.curve == k])) if len(network.curves) <= 2000 else -1
        features.append(
            FeatureBudget(
                "spline", curve.id, seen, int(count[k]), int(2 * count[k]), free + int(count[k] - held_of[k])
            )
        )
    rays = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
    free_points = layout.point_mask.sum(axis=1)
    features += [
        FeatureBudget("point", id_, int(rays[k]), int(rays[k]), int(2 * rays[k]), int(free_points[k]))
        for k, id_ in enumerate(network.points.ids)
    ]
    return tuple(features)


def _images(network: Network) -> tuple[ImageBudget, ...]:
    observed = network.curve_observations
    count = len(network.images.ids)
    spline_points = np.bincount(observed.image, minlength=count)
    points = np.bincount(network.point_observations.image, minlength=count)
    pairs = np.unique(observed.image * max(len(network.curves), 1) + observed.curve) // max(
        len(network.curves), 1
    )
    splines = np.bincount(pairs, minlength=count)
    return tuple(
        ImageBudget(
            id_,
            int(spline_points[k]),
            int(points[k]),
            int(splines[k]),
            int(2 * (spline_points[k] + points[k])),
        )
        for k, id_ in enumerate(network.images.ids)
    )
