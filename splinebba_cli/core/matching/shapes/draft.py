"""New curves with the unlabelled points linked to them, as a network of their own: orientations are held."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.curve_stage import solve_curves
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.matching.shapes.place_fit import PlaceFit
from splinebba_cli.core.network import (
    ArcLengths,
    BoolArray,
    Curve,
    CurveObservations,
    Distances,
    FloatArray,
    IntArray,
    Network,
    PointObservations,
    Points,
    Tangents,
    select_rows,
)
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows, concatenate_rows, gauge_rows
from splinebba_cli.core.observations.curve_points import CurveRows, linearize_curve_points
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.row_groups import split_by
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

ITERATIONS = 20
SLIDING = 0.2  # of the usual sigma of knots along the curve
HOLD = 0.1  # sigma of the knots of a draft, of the length of the curve


@dataclass(frozen=True)
class Draft:
    """Curves and links at present; link k is curve observation k of the network of new curves."""

    prepared: Prepared
    state: State
    row: IntArray  # (n,) unlabelled point of every link

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The new curves."""
        return self.prepared.network.curves

    @property
    def links(self) -> CurveObservations:
        """The linked points as curve observations."""
        return self.prepared.network.curve_observations

    @cached_property
    def links_by_curve(self) -> list[IntArray]:
        """The links of every curve, ascending."""
        return split_by(self.links.curve, len(self.curves))

    def equations(self) -> CurveRows:
        """Equations across the curves; row k belongs to link k for the first n rows."""
        return linearize_curve_points(
            self.prepared, self.state, held_locations(self.prepared, self.state.location)
        )

    def holding_rows(self) -> CoefficientRows:
        """Equations that hold knots along the curves and, weakly, where they are."""
        return _assembler(self.prepared).coefficient_rows

    def coefficients_of(self, curve: int) -> FloatArray:
        """Present coefficients of one curve, (m, 3)."""
        start = self.prepared.curves.coefficient_start
        return self.state.coefficients[int(start[curve]) : int(start[curve + 1])]

    def present_curves(self) -> tuple[Curve, ...]:
        """The new curves with their present knots."""
        return tuple(
            replace(
                curve,
                values=basis.values_from_coefficients(self.coefficients_of(k)),
                sigma=np.full(curve.values.shape, np.inf),
                knot_parameters=basis.break_points.copy(),
                reference=None,
            )
            for k, (curve, basis) in enumerate(zip(self.curves, self.prepared.curves.bases, strict=True))
        )

    def with_links(self, keep: BoolArray) -> Draft:
        """The same with some of the links, (n,) kept ones."""
        if keep.all():
            return self
        network = self.prepared.network
        kept = np.flatnonzero(keep)
        prepared = prepare(
            replace(
                network,
                curves=_held(self.present_curves()),
                curve_observations=select_rows(network.curve_observations, kept),
            )
        )
        state = replace(
            self.state, location=self.state.location[kept], coefficients=initial_coefficients(prepared)
        )
        return Draft(prepared, state, self.row[kept])

    def solved(self) -> Draft:
        """The same with the curves adjusted, orientations held."""
        if not self.curves:
            return self
        state = solve_curves(_assembler(self.prepared), self.state, max_iterations=ITERATIONS)
        return replace(self, state=state)


def draft_of(
    network: Network, state: State, curves: tuple[Curve, ...], row: IntArray, curve: IntArray, location: FloatArray
) -> Draft:  # fmt: skip
    """A draft at given orientations; knots are held weakly where they are, against parts that no image determines.

    Parameters
    ----------
    network : with the unlabelled points
    state : whose orientations are held
    curves : new ones
    row, curve, location : (n,) links; NaN where a location is unknown
    """
    points = network.unlabelled
    order = np.lexsort((row, curve))
    row, curve, location = row[order], curve[order], location[order]
    links = CurveObservations(
        points.image[row], curve, points.photo_xy[row], points.sigma[row], location, np.full(len(row), -1)
    )
    whole, three = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    prepared = prepare(
        replace(
            network,
            curves=_held(curves),
            curve_observations=links,
            points=Points((), (), three, three, three),
            point_observations=PointObservations(whole, whole, np.zeros((0, 2)), np.zeros((0, 2))),
            arc_lengths=ArcLengths.none(),
            tangents=Tangents.none(),
            distances=Distances.none(),
        )
    )
    begin = State(state.rotation, state.position, initial_coefficients(prepared), three, links.location)
    return Draft(prepared, search_locations(prepared, begin), row)


def with_curves(draft: Draft, curves: tuple[Curve, ...]) -> Draft:
    """The same links on curves with other knots; locations are searched again."""
    prepared = prepare(replace(draft.prepared.network, curves=_held(curves)))
    begin = replace(
        draft.state, coefficients=initial_coefficients(prepared), location=np.full(len(draft.row), np.nan)
    )
    return Draft(prepared, search_locations(prepared, begin), draft.row)


def _assembler(prepared: Prepared) -> Assembler:
    """Equations of the curves alone: knots stay nearly where they are along the curve, others are inserted at need."""
    layout = layout_of(prepared).hold_images()
    free = tuple(replace(c, sigma=np.full(c.sigma.shape, np.inf)) for c in prepared.network.curves)
    unheld = replace(prepared, network=replace(prepared.network, curves=free))
    gauge = gauge_rows(unheld, layout.coefficient_mask, prepared.network.settings.gauge_sigma_m)
    curves = prepared.network.curves
    pairs = zip(gauge.curve.tolist(), gauge.row.tolist(), strict=True)
    corner = np.array([row in curves[curve].breaks for curve, row in pairs], dtype=bool)
    along, at_corner = gauge.select(np.flatnonzero(~corner)), gauge.select(np.flatnonzero(corner))
    rows = [control_rows(prepared, layout.coefficient_mask), along.with_sigma_times(SLIDING), at_corner]
    return Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))


def _held(curves: tuple[Curve, ...]) -> tuple[Curve, ...]:
    """Curves whose knots have a weak prior: a share of the length of the curve."""
    held = []
    for curve in curves:
        length = float(np.linalg.norm(np.diff(curve.values, axis=0), axis=1).sum())
        held.append(replace(curve, sigma=np.full(curve.values.shape, HOLD * length)))
    return tuple(held)


def curve_of_fit(fit: PlaceFit, id: str) -> Curve:
    """A fitted spline as a tie curve whose knots are free."""
    knots, parameters = fit.knots, fit.basis.break_points.copy()
    return Curve(
        id, "tie", "natural_cubic", knots, np.full(knots.shape, np.inf),
        closed=fit.basis.closed, knot_parameters=parameters,
    )  # fmt: skip
