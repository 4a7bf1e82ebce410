"""Equations of linked points: along the curve, arc lengths and tangents, with the locations of each chain eliminated.

The equation across the curve of a linked point does not hold its location and stays with all others
(:mod:`~splinebba_cli.core.observations.curve_points`).  What is left of a chain after the elimination couples one
image and all coefficients under the chain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.chains import Chains
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.observations.arc_lengths import linearize_arc_lengths
from splinebba_cli.core.observations.chain_elimination import (
    ChainRows,
    EliminatedChains,
    eliminate_chains,
)
from splinebba_cli.core.observations.tangents import linearize_tangents
from splinebba_cli.core.state import Prepared, State

BATCH_POINTS = 4000


@dataclass(frozen=True)
class LinkedBatch:
    """Chains of similar length: their rows over (theta, X0) of the image and the coefficients under the chain."""

    chains: Chains
    image: IntArray  # (G,)
    columns: IntArray  # (G, m) coefficients under each chain, the first one repeated as padding
    rows: ChainRows  # (G, L, 6 + 3 m + 1)
    eliminated: EliminatedChains


@dataclass(frozen=True)
class LinkedEquations:
    """All chains of a network, linearised."""

    batches: tuple[LinkedBatch, ...]
    along: (
        FloatArray  # (n,) whitened residual along the curve of every measured point, 0 where it is not linked
    )
    arc_residual: FloatArray  # (q,) whitened
    tangent_residual: FloatArray  # (t,) whitened

    @property
    def cost(self) -> float:
        """Sum of squares of all rows, at the present locations."""
        if not self.batches:
            return 0.0
        return float(
            self.along @ self.along
            + self.arc_residual @ self.arc_residual
            + self.tangent_residual @ self.tangent_residual
        )

    def of_points(self, prepared: Prepared) -> FloatArray:
        """The same sum, shared among the measured points: an arc belongs to its first point, (n,)."""
        network = prepared.network
        count = len(self.along)
        return np.asarray(
            self.along**2
            + np.bincount(network.arc_lengths.first, self.arc_residual**2, minlength=count)
            + np.bincount(network.tangents.point, self.tangent_residual**2, minlength=count)
        )


def linearize_linked_points(prepared: Prepared, state: State, held: IntArray) -> LinkedEquations:
    """Rows of all chains at a state, their locations eliminated.

    Parameters
    ----------
    held : (h,) measured points whose location is no unknown

    Raises
    ------
    FloatingPointError
        If part of a chain lies behind a camera.
    """
    count = len(prepared.network.curve_observations)
    along = np.zeros(count)
    arc = np.zeros(len(prepared.network.arc_lengths))
    tangent = np.zeros(len(prepared.network.tangents))
    is_held = np.zeros(count, dtype=bool)
    is_held[held] = True
    batches = []
    for chains in prepared.chains.batches(BATCH_POINTS):
        batch = _linearized_batch(prepared, state, chains, is_held)
        batches.append(batch)
        for out, place, rows in (
            (along, chains.points, batch.rows.along),
            (arc, chains.arcs, batch.rows.arc),
            (tangent, chains.tangents, batch.rows.tangent),
        ):
            used = place >= 0
            out[place[used]] = rows[used][:, -1]
    return LinkedEquations(tuple(batches), along, arc, tangent)


@dataclass(frozen=True)
class _Columns:
    """Coefficients under each chain of a batch."""

    table: IntArray  # (G, m)
    keys: IntArray  # sorted chain * coefficient_count + coefficient
    starts: IntArray  # (G,) first key of each chain
    coefficient_count: int

    @classmethod
    def of(cls, chain: IntArray, columns: IntArray, chains: int, coefficient_count: int) -> _Columns:
        keys = np.unique(chain[:, None] * coefficient_count + columns)
        owner = keys // coefficient_count
        starts = np.searchsorted(owner, np.arange(chains))
        number = np.diff(np.append(starts, len(keys)))
        place = starts[:, None] + np.arange(int(number.max()))
        inside = np.arange(int(number.max())) < number[:, None]
        table = keys[np.where(inside, place, starts[:, None])] % coefficient_count
        return cls(table, keys, starts, coefficient_count)

    def positions(self, chain: IntArray, columns: IntArray) -> IntArray:
        """Place of coefficients (k, w) in the list of their chain (k,)."""
        found = np.searchsorted(self.keys, chain[:, None] * self.coefficient_count + columns)
        return np.asarray(found - self.starts[chain][:, None])


def _linearized_batch(prepared: Prepared, state: State, chains: Chains, is_held: BoolArray) -> LinkedBatch:
    observed, curves = prepared.network.curve_observations, prepared.curves
    g, i = np.nonzero(chains.points >= 0)
    ga, ia = np.nonzero(chains.arcs >= 0)
    gt, it = np.nonzero(chains.tangents >= 0)
    point, arc, tangent = chains.points[g, i], chains.arcs[ga, ia], chains.tangents[gt, it]
    arcs = linearize_arc_lengths(prepared, state, arc)
    tangents = linearize_tangents(prepared, state, tangent)
    along = along_rows(prepared, state, point)
    node_chain = ga[arcs.node_arc]
    under = _Columns.of(
        np.concatenate([g, node_chain]),
        curves.columns[np.concatenate([along.segment, arcs.node_segment])],
        len(chains),
        curves.coefficient_count,
    )
    size = under.table.shape[1]

    def rows(
        owner: IntArray, chain: IntArray, orientation: FloatArray, segment: IntArray, local: FloatArray,
        residual: FloatArray, which: IntArray,
    ) -> FloatArray:  # fmt: skip
        """Rows (k, 6 + 3 m + 1): `owner` is the row of every block of coefficients."""
        out = np.zeros((len(residual), 6 + 3 * size + 1))
        out[:, :6], out[:, -1] = orientation, residual
        place = owner[:, None] * size + under.positions(chain[which], curves.columns[segment])
        block = np.zeros((len(residual) * size, 3))
        for d in range(3):
            block[:, d] = np.bincount(place.ravel(), local[:, :, d].ravel(), minlength=len(block))
        out[:, 6:-1] = block.reshape(len(residual), 3 * size)
        return out

    every, every_tangent = np.arange(len(point)), np.arange(len(tangent))
    shape = (*chains.points.shape, 6 + 3 * size + 1)
    free = ~is_held
    batch = ChainRows(
        along=_placed(
            shape, g, i,
            rows(every, g, along.orientation, along.segment, along.coefficients, along.residual, every),
        ),
        along_slope=_placed(shape[:2], g, i, along.slope * free[point]),
        tangent=_placed(
            shape, gt, it,
            rows(every_tangent, gt, tangents.orientation, tangents.segment, tangents.coefficients, tangents.residual,
                 every_tangent),
        ),
        tangent_slope=_placed(shape[:2], gt, it, tangents.slope * free[prepared.network.tangents.point[tangent]]),
        arc=_placed(
            (shape[0], shape[1] - 1, shape[2]), ga, ia,
            rows(arcs.node_arc, ga, arcs.orientation, arcs.node_segment, arcs.node_coefficients, arcs.residual,
                 arcs.node_arc),
        ),
        arc_slopes=_placed((shape[0], shape[1] - 1, 2), ga, ia, arcs.slopes * _free_ends(prepared, arc, free)),
    )  # fmt: skip
    image = observed.image[chains.points[:, 0]]
    return LinkedBatch(chains, image, under.table, batch, eliminate_chains(batch))


def _free_ends(prepared: Prepared, arc: IntArray, free: BoolArray) -> FloatArray:
    arcs = prepared.network.arc_lengths
    return np.stack([free[arcs.first[arc]], free[arcs.second[arc]]], axis=1)


def _placed(shape: tuple[int, ...], chain: IntArray, place: IntArray, values: FloatArray) -> FloatArray:
    out = np.zeros(shape)
    out[chain, place] = values
    return out
