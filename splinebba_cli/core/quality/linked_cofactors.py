"""Cofactors of the locations of linked points, and what their observations take from the redundancy.

With T = B'B of the locations of a chain, S = T^-1 B'J over its parameters p and Q the cofactors of p,

    Q_up = -S Q,    Q_uu = T^-1 + S Q S',

so that the leverage of a row (j, b) over p and u is (j - b S) Q (j - b S)' + b T^-1 b'; b touches two neighbouring
locations at most, of which the recursion of the triangle gives T^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.linked_windows import LinkedWindows
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors


@dataclass(frozen=True)
class LinkedCofactors:
    """Leverages of the observations of all chains, and cofactors of their locations; 0 where there is none."""

    along: FloatArray  # (n,) leverage of the equation along the curve
    arc: FloatArray  # (q,)
    tangent: FloatArray  # (t,)
    location: FloatArray  # (n,) Q_uu


def linked_cofactors(cofactors: Cofactors) -> LinkedCofactors:
    """Leverages and location cofactors of all linked points."""
    at, network = cofactors.solution.linearization, cofactors.assembler.prepared.network
    count = len(network.curve_observations)
    out = LinkedCofactors(
        np.zeros(count), np.zeros(len(network.arc_lengths)), np.zeros(len(network.tangents)), np.zeros(count)
    )
    for window in at.linked_windows:
        _add_batch(cofactors, window, out)
    return out


def _add_batch(cofactors: Cofactors, window: LinkedWindows, out: LinkedCofactors) -> None:
    batch, q = window.batch, window.window.gather(cofactors.values)
    rows, chains = batch.rows, batch.chains
    sensitivity = batch.eliminated.solve(window.masked(batch.eliminated.pivot))
    own, beside = batch.eliminated.location_cofactors()

    def quadratic(effective: FloatArray) -> FloatArray:
        return np.asarray(np.sum(np.matmul(effective, q) * effective, axis=2))

    def at_points(jacobian: FloatArray, slope: FloatArray) -> FloatArray:
        return quadratic(window.masked(jacobian) - slope[:, :, None] * sensitivity) + slope**2 * own

    d, e = rows.arc_slopes[:, :, 0], rows.arc_slopes[:, :, 1]
    bent = d[:, :, None] * sensitivity[:, :-1] + e[:, :, None] * sensitivity[:, 1:]
    arc = quadratic(window.masked(rows.arc) - bent)
    arc += d**2 * own[:, :-1] + 2.0 * d * e * beside + e**2 * own[:, 1:]
    for target, place, values in (
        (out.along, chains.points, at_points(rows.along, rows.along_slope)),
        (out.tangent, chains.tangents, at_points(rows.tangent, rows.tangent_slope)),
        (out.arc, chains.arcs, arc),
        (out.location, chains.points, own + quadratic(sensitivity)),
    ):
        used = place >= 0
        target[place[used]] = values[used]
