"""What the equations of every feature and image determine: ranks of their own design matrices.

With A = [A_u A_o] the equations of one feature over its own unknowns (coefficients or coordinates) and the
orientations of the images that see it, locations eliminated,

    rank                      rank A_u + locations     with the orientations known
    redundancy                equations - rank
    orientation conditions    rank A - rank A_u        part of this redundancy that determines orientations;
                                                       the rest only checks

The rank of an image is that of its equations over its own orientation, the features known.  A feature's share of
the rank of the whole network would say less: in a good block it is just its number of unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.numerical_rank import numerical_rank
from splinebba_cli.core.estimation.own_equations import OwnEquations, OwnMatrix
from splinebba_cli.core.network import IntArray

MOST_FEATURES = 5000  # beyond, ranks of single features are left out
WORK = 4e9  # floating-point operations for all decompositions of curves together
SHARE = 2e8  # that every curve may take, however many there are up to WORK / SHARE


@dataclass(frozen=True)
class FeatureRank:
    """Ranks of one feature; without its locations."""

    own: int
    orientation_conditions: int
    independent_points: int | None  # curves: sum over images of the rank of the equations across it


def curve_ranks(equations: OwnEquations) -> list[FeatureRank | None]:
    """Of every curve; None where the matrix is too large for a dense decomposition."""
    count = len(equations.assembler.prepared.network.curves)
    if count > MOST_FEATURES:
        return [None] * count
    limit = max(SHARE if count <= WORK / SHARE else 0.0, WORK / max(count, 1))
    found: list[FeatureRank | None] = []
    for k in range(count):
        rows, columns = equations.curve_size(k)
        if float(rows) * columns**2 > limit:
            found.append(None)
            continue
        across = sum(numerical_rank(matrix) for matrix in equations.across(k))
        found.append(_rank(equations.of_curve(k), across))
    return found


def point_ranks(equations: OwnEquations) -> list[FeatureRank | None]:
    """Of every object point; all None where there are very many."""
    count = len(equations.assembler.prepared.network.points.ids)
    if count > MOST_FEATURES:
        return [None] * count
    return [_rank(equations.of_point(k), None) for k in range(count)]


def image_ranks(equations: OwnEquations) -> IntArray:
    """Rank of the equations of every image over its orientation, features known, (m,)."""
    return np.array([numerical_rank(matrix) for matrix in equations.of_images()], dtype=np.int64)


def _rank(matrix: OwnMatrix, independent_points: int | None) -> FeatureRank:
    own = numerical_rank(matrix.unknowns)
    both = (
        numerical_rank(np.hstack([matrix.unknowns, matrix.orientations]))
        if matrix.orientations.any()
        else own
    )
    return FeatureRank(own, both - own, independent_points)
