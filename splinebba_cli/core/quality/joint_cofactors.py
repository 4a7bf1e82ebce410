"""Cofactors of several linear functions of the reduced unknowns together: B N^-1 B' by solves, one a function.

The selected inverse holds covariances of neighbours only; what lies far apart needs the columns of the inverse.
For object points, x = H^-1 h - sum_a M_a theta_a (elimination.py) gives

    Q_nm = delta_nm H^-1 + sum_{a of n, b of m} M_a Q_ab M_b'
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors

LARGEST = 3e7  # numbers in B: 240 MB


def too_many(cofactors: Cofactors, functions: int) -> bool:
    """Whether B would be too large for so many functions."""
    return float(functions) * float(cofactors.assembler.layout.node_starts[-1]) > LARGEST


def cofactors_of(cofactors: Cofactors, functions: FloatArray) -> FloatArray:
    """Cofactors (k, k) of functions (k, N) of the reduced unknowns."""
    found = _solved(cofactors, functions)
    if cofactors.datum is None:
        return found
    g, h = (functions @ rows for rows in cofactors.datum.on_reduced(cofactors.assembler.layout))
    return np.asarray(found - g @ h.T - h @ g.T)


def _solved(cofactors: Cofactors, functions: FloatArray) -> FloatArray:
    """The same in the datum of the solution."""
    factor = cofactors.solution.factor
    if factor is None:
        raise ValueError("no factor")
    masked = functions * cofactors.assembler.mask
    return np.asarray(masked @ factor.solve(masked.T))


def point_cofactors(cofactors: Cofactors, points: IntArray) -> FloatArray:
    """Cofactors (3 k, 3 k) of the coordinates of some object points together."""
    assembler, eliminated = cofactors.assembler, cofactors.solution.eliminated
    if eliminated is None:
        raise ValueError("no eliminated points")
    observed, layout = assembler.prepared.network.point_observations, assembler.layout
    count = len(points)
    place = np.full(len(assembler.prepared.network.points.ids), -1)
    place[points] = np.arange(count)
    rows = np.flatnonzero(place[observed.point] >= 0)
    mask = layout.eliminated_mask[points]
    own = eliminated.inverse[points] * mask[:, :, None] * mask[:, None, :]
    at = place[observed.point[rows]]
    back = np.matmul(own[at], eliminated.coupling[rows].transpose(0, 2, 1))  # M (q, 3, 6)
    functions = np.zeros((count, 3, int(layout.node_starts[-1])))
    columns = ORIENTATION_SIZE * observed.image[rows][:, None] + np.arange(ORIENTATION_SIZE)
    np.add.at(functions, (at[:, None, None], np.arange(3)[None, :, None], columns[:, None, :]), -back)
    kept = np.flatnonzero(layout.node_of_point[points] >= 0)  # these are unknowns of the reduced system
    functions[kept[:, None], np.arange(3), layout.unknown_of_point[points[kept]]] = 1.0
    joint = _solved(cofactors, functions.reshape(3 * count, -1))
    blocks = joint.reshape(count, 3, count, 3)
    n = np.arange(count)
    blocks[n, :, n, :] += own
    return joint if cofactors.datum is None else cofactors.datum.of_points_together(joint, points)
