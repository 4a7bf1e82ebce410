"""The redundancy budget of a network before its adjustment: counts, rank, and who determines what.

Equations and unknowns of the measurements and priors alone, before gauge and datum conditions, at the approximate
values with every curve point measured exactly at its location
(:mod:`~splinebba_cli.core.observations.structural_locations`).  A measured curve point brings two equations and one
location; redundancy = equations - rank.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.approximation.misfit import misfit_of_given, told_of_misfit
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.core.estimation.counts import count_equations
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.own_equations import OwnEquations
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.estimation.rank_diagnosis import null_space
from splinebba_cli.core.network import IntArray, Network
from splinebba_cli.core.observations.coefficient_rows import SHAPE, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.observations.structural_locations import structural_state
from splinebba_cli.core.quality.dissertation_count import (
    printed_count_of_curve,
    printed_count_of_point,
    printed_independent_points,
    reason_of_curve,
)
from splinebba_cli.core.quality.gauge_defects import before_conditions
from splinebba_cli.core.quality.null_problems import null_problems
from splinebba_cli.core.quality.rank_contributions import FeatureRank, curve_ranks, image_ranks, point_ranks
from splinebba_cli.core.result import Problem
from splinebba_cli.core.revision.revise import begin_search
from splinebba_cli.core.state import Prepared, prepare
from splinebba_cli.errors import SingularNetworkError

EQUATIONS = ("arc_lengths", "tangents", "given_values", "shape_conditions")  # of splines beside 2 a point

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class FeatureBudget:
    """Counts of one curve or point and the rank of its own equations.

    ``rank`` is that of its equations with the orientations known, ``orientation_conditions`` what they give to the
    orientations beyond (:mod:`~splinebba_cli.core.quality.rank_contributions`); None where the matrix is too large.
    ``lee_...`` is the count of Lee (2008), tables 5.1 and 5.2, None where these know nothing of the kind, and
    ``reason`` says why it differs (:mod:`~splinebba_cli.core.quality.dissertation_count`).
    """

    kind: str  # "spline" or "point"
    id: str
    role: str
    images: int
    observations: int  # measured image points
    equations: int  # 2 observations + arc_lengths + tangents + given_values + shape_conditions
    unknowns: int  # coefficients + locations
    arc_lengths: int
    tangents: int
    given_values: int  # equations of weighted values or coordinates
    shape_conditions: int
    coefficients: int  # or coordinates
    locations: int
    gauge_conditions: int  # offered, one an anchor; an adjustment keeps those that it needs
    rank: int | None
    redundancy: int | None  # equations - rank
    orientation_conditions: int | None  # independent conditions on the orientations
    independent_points: int | None  # of splines: sum over images of the rank of the equations across it
    lee_unknowns: int | None
    lee_redundancy: int | None
    lee_independent_points: int | None
    reason: str


@dataclass(frozen=True)
class ImageBudget:
    """Counts of one image and the rank of its equations with the features known."""

    id: str
    spline_points: int
    points: int
    splines: int
    equations: int  # 2 (spline_points + points) + arc_lengths + tangents + priors
    arc_lengths: int
    tangents: int
    priors: int
    orientation: int  # unknowns of its exterior orientation
    locations: int
    unknowns: int
    rank: int
    redundancy: int  # equations - rank


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
        If there are no approximate values to count at, or they put features behind the images.
    """
    _log.info("approximate values")
    network = begin_search(network).part.network
    with told_of_misfit(network):
        return _budget(network)


def _budget(network: Network) -> Budget:
    prepared = prepare(network)
    state, problems = starting_state(prepared)
    try:
        structure = structural_state(prepared, state)
        layout = layout_of(prepared)
        control = control_rows(prepared, layout.coefficient_mask)
        assembler = Assembler(structure.prepared, layout, control)
        at = assembler.linearize(structure.state, structure.held)
    except FloatingPointError as error:
        help = "check signs, units and rotation sequence"
        raise SingularNetworkError(
            [Problem("SBB505", "error", str(error), "approximate values", help)]
        ) from error
    counted = _Counted(structure.prepared, assembler, at, structure.held)
    equations = count_equations(assembler, at)
    locations = len(network.curve_observations) - len(structure.held)
    _log.info("rank")
    null = null_space(assembler, at)
    unknowns, rank = null.unknowns + locations, null.rank + locations
    named = null_problems(null, layout, network)
    _log.info("budgets of features and images")
    with one_thread():  # many small matrices
        features, images = (*counted.splines(), *counted.points()), counted.images()
    nulls = {
        each.id: each.unknowns - each.rank
        for each in features
        if each.kind == "spline" and each.rank is not None
    }
    seen = before_conditions((*misfit_of_given(network), *problems, *named), network, nulls)
    return Budget(equations, unknowns, rank, unknowns - rank, equations - rank, features, images, seen)


@dataclass(frozen=True)
class _Counted:
    """A linearised network whose features and images are counted."""

    prepared: Prepared
    assembler: Assembler
    at: Linearization
    held: IntArray

    @property
    def network(self) -> Network:
        return self.prepared.network

    @cached_property
    def own(self) -> OwnEquations:
        return OwnEquations(self.assembler, self.at)

    def splines(self) -> list[FeatureBudget]:
        network, count = self.network, len(self.network.curves)
        observed, rows = network.curve_observations, self.assembler.coefficient_rows
        gauge = gauge_rows(
            self.prepared, self.assembler.layout.coefficient_mask, network.settings.gauge_sigma_m
        )
        segment = self.prepared.curves.locate(observed.curve, self.at.state.location)[0]
        table = {
            "arc_lengths": np.bincount(observed.curve[network.arc_lengths.first], minlength=count),
            "tangents": np.bincount(observed.curve[network.tangents.point], minlength=count),
            "given_values": np.bincount(rows.curve[rows.component != SHAPE], minlength=count),
            "shape_conditions": np.bincount(rows.curve[rows.component == SHAPE], minlength=count),
            "gauge_conditions": np.bincount(gauge.curve, minlength=count),
            "images": self.own.image_counts,
            "observations": np.bincount(observed.curve, minlength=count),
            "held": np.bincount(observed.curve[self.held], minlength=count),
            "printed": printed_independent_points(self.prepared, segment),
        }
        lists = {key: counts.tolist() for key, counts in table.items()}
        ranks = curve_ranks(self.own)
        return [
            self._spline(k, {key: counts[k] for key, counts in lists.items()}, ranks[k]) for k in range(count)
        ]

    def _spline(self, number: int, count: dict[str, int], rank: FeatureRank | None) -> FeatureBudget:
        curve, points = self.network.curves[number], count["observations"]
        starts = self.prepared.curves.coefficient_start
        free = self.assembler.layout.coefficient_mask[starts[number] : starts[number + 1]] > 0.0
        coefficients, locations = int(free.sum()), points - count.pop("held")
        printed = printed_count_of_curve(
            self.prepared, number, points, count["arc_lengths"], count.pop("printed")
        )
        equations = 2 * points + sum(count[kind] for kind in EQUATIONS)
        whole = None if rank is None else rank.own + locations
        return FeatureBudget(
            kind="spline",
            id=curve.id,
            role=curve.role,
            equations=equations,
            unknowns=coefficients + locations,
            coefficients=coefficients,
            locations=locations,
            rank=whole,
            redundancy=None if whole is None else equations - whole,
            orientation_conditions=None if rank is None else rank.orientation_conditions,
            independent_points=None if rank is None else rank.independent_points,
            lee_unknowns=printed.unknowns,
            lee_redundancy=printed.redundancy,
            lee_independent_points=printed.independent_points,
            reason=reason_of_curve(self.prepared, number, free, locations, rank, printed),
            **count,
        )

    def points(self) -> list[FeatureBudget]:
        points = self.network.points
        rays = np.bincount(self.network.point_observations.point, minlength=len(points.ids))
        free = self.assembler.layout.point_mask.sum(axis=1)
        given = np.count_nonzero(self.assembler.point_inverse_sigma > 0.0, axis=1)
        ranks = point_ranks(self.own)
        return [
            _point(id_, points.role[k], int(rays[k]), int(free[k]), int(given[k]), ranks[k])
            for k, id_ in enumerate(points.ids)
        ]

    def images(self) -> tuple[ImageBudget, ...]:
        network, count = self.network, len(self.network.images.ids)
        observed, curves = network.curve_observations, max(len(network.curves), 1)
        priors = np.zeros(count, dtype=np.int64)
        priors[self.at.orientation_priors.image] = self.at.orientation_priors.active.sum(axis=1)
        spline_points = np.bincount(observed.image, minlength=count)
        points = np.bincount(network.point_observations.image, minlength=count)
        splines = np.bincount(np.unique(observed.image * curves + observed.curve) // curves, minlength=count)
        arcs = np.bincount(observed.image[network.arc_lengths.first], minlength=count)
        tangents = np.bincount(observed.image[network.tangents.point], minlength=count)
        orientation = self.assembler.layout.image_mask.sum(axis=1).astype(np.int64)
        locations = spline_points - np.bincount(observed.image[self.held], minlength=count)
        equations = 2 * (spline_points + points) + arcs + tangents + priors
        rank = image_ranks(self.own) + locations
        columns = (
            spline_points, points, splines, equations, arcs, tangents, priors, orientation, locations,
            orientation + locations, rank, equations - rank,
        )  # fmt: skip
        return tuple(
            ImageBudget(id_, *(int(c[k]) for c in columns)) for k, id_ in enumerate(network.images.ids)
        )


def _point(id: str, role: str, rays: int, free: int, given: int, rank: FeatureRank | None) -> FeatureBudget:
    printed = printed_count_of_point(rays, free, given)
    return FeatureBudget(
        kind="point",
        id=id,
        role=role,
        images=rays,
        observations=rays,
        equations=2 * rays + given,
        unknowns=free,
        arc_lengths=0,
        tangents=0,
        given_values=given,
        shape_conditions=0,
        coefficients=free,
        locations=0,
        gauge_conditions=0,
        rank=None if rank is None else rank.own,
        redundancy=None if rank is None else 2 * rays + given - rank.own,
        orientation_conditions=None if rank is None else rank.orientation_conditions,
        independent_points=None,
        lee_unknowns=printed.unknowns,
        lee_redundancy=printed.redundancy,
        lee_independent_points=None,
        reason=""
        if rank is None or rank.own == free
        else f"rank {rank.own} of {free}: too few rays or parallel ones",
    )
