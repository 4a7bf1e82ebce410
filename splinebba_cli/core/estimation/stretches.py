"""Stretches of curves: the parts of them that damping, restlessness and conditions are decided for.

    one stretch = a curve, or one node of the reduced system (four coefficients) of a very long one

One stretch of a coastline of thousands of knots that bends too far must not hold back all others, as one curve must
not hold back other curves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

LONG = 32  # nodes beyond which a curve is divided


@dataclass(frozen=True)
class Stretches:
    """The stretches of all curves, curve by curve, in their order along it."""

    layout: ParameterLayout
    curves: CurveSet
    curve: IntArray  # (s,) curve of every stretch
    first: IntArray  # (nc,) first stretch of every curve
    whole: BoolArray  # (s,) the stretch is all of its curve
    of_node: IntArray  # (k,) stretch of every node of curves

    @classmethod
    def of(cls, layout: ParameterLayout, curves: CurveSet) -> Stretches:
        """Those of a layout."""
        of_nodes = layout.node_curve[layout.node_curve >= 0]
        nodes = np.bincount(of_nodes, minlength=len(curves.bases))
        number = np.where(nodes > LONG, nodes, np.minimum(nodes, 1))
        first = np.cumsum(number) - number
        within = np.arange(len(of_nodes)) - (np.cumsum(nodes) - nodes)[of_nodes]
        of_node = first[of_nodes] + np.where(nodes[of_nodes] > LONG, within, 0)
        curve = np.repeat(np.arange(len(nodes)), number)
        return cls(layout, curves, curve, first, number[curve] == 1, of_node)

    def of_columns(self, columns: IntArray) -> IntArray:
        """Stretch of windows of coefficients (n, w), that of the second: (n,)."""
        node = self.layout.node_of_coefficient[columns[:, min(1, columns.shape[1] - 1)]]
        return self.of_node[node - self.layout.image_count]

    def of_segments(self) -> IntArray:
        """Stretch of every segment, (S,)."""
        return self.of_columns(self.curves.columns)

    def of_points(self, curve: IntArray, location: FloatArray) -> IntArray:
        """Stretch of places on curves, (n,); only long curves are searched for their segments."""
        stretch: IntArray = self.first[curve]
        along = np.flatnonzero(~self.whole[stretch])
        if len(along):
            segment = self.curves.locate(curve[along], location[along])[0]
            stretch[along] = self.of_columns(self.curves.columns[segment])
        return stretch

    def of_unknowns(self, values: FloatArray) -> FloatArray:
        """Values of stretches (s,) for all reduced unknowns, (N,); 0 for those of images and points."""
        of_nodes = np.zeros(len(self.layout.node_sizes))
        of_nodes[self.layout.image_count : self.layout.image_count + len(self.of_node)] = values[self.of_node]
        return np.repeat(of_nodes, self.layout.node_sizes)

    def with_neighbours(self, chosen: BoolArray) -> BoolArray:
        """The chosen stretches, and those before and after them on their curves: a segment has coefficients of both."""
        wide = chosen.copy()
        joined = self.curve[1:] == self.curve[:-1]
        wide[1:] |= chosen[:-1] & joined
        wide[:-1] |= chosen[1:] & joined
        return wide


def costs_of(
    assembler: Assembler, at: Linearization, of_points: IntArray, of_rows: IntArray, count: int
) -> FloatArray:
    """Sum of squares by owners of the measured curve points (n,) and coefficient rows (q,), (count,)."""
    cost = np.bincount(of_points, at.on_curves.squares, minlength=count)
    if len(assembler.prepared.chains):
        cost += np.bincount(of_points, at.linked.of_points(assembler.prepared), minlength=count)
    return np.asarray(cost + np.bincount(of_rows, at.coefficient_residual**2, minlength=count))


def curve_costs(assembler: Assembler, at: Linearization) -> FloatArray:
    """Sum of squares that belongs to each curve, (nc,)."""
    observed, rows = assembler.prepared.network.curve_observations, assembler.coefficient_rows
    return costs_of(assembler, at, observed.curve, rows.curve, len(assembler.prepared.curves.bases))


def stretch_costs(
    assembler: Assembler, stretches: Stretches, before: Linearization, after: Linearization
) -> tuple[FloatArray, FloatArray]:
    """Sums of squares that belong to each stretch before and after a step, (s,) each.

    Points belong to the stretches of their locations before.
    """
    observed, count = assembler.prepared.network.curve_observations, len(stretches.curve)
    of_points = stretches.of_points(observed.curve, before.state.location)
    of_rows = stretches.of_columns(assembler.coefficient_rows.columns)
    return (
        costs_of(assembler, before, of_points, of_rows, count),
        costs_of(assembler, after, of_points, of_rows, count),
    )
