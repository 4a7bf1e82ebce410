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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.estimation.numerical_rank import nested_ranks, numerical_ranks
from splinebba_cli.core.estimation.own_equations import OwnEquations
from splinebba_cli.core.network import IntArray
from splinebba_cli.core.threads import in_threads

MOST_FEATURES = 50_000  # beyond, ranks of single features are left out
WORK = 4e9  # floating-point operations for all decompositions of curves together, cheap ones first
BATCH = 300_000  # entries of matrices that are decomposed together


@dataclass(frozen=True)
class FeatureRank:
    """Ranks of one feature; without its locations."""

    own: int
    orientation_conditions: int
    independent_points: int | None  # curves: sum over images of the rank of the equations across it


def curve_ranks(equations: OwnEquations) -> list[FeatureRank | None]:
    """Of every curve; None where the matrix is too large for a dense decomposition."""
    count = len(equations.coefficient_counts)
    found: list[FeatureRank | None] = [None] * count
    if count > MOST_FEATURES or not count:
        return found
    sizes, images = 3 * equations.coefficient_counts, equations.image_counts
    columns = sizes + 6 * images
    work = equations.row_counts * columns.astype(np.float64) ** 2
    cheapest = np.argsort(work, kind="stable")
    small = np.sort(cheapest[np.cumsum(work[cheapest]) <= WORK])

    def ranks(chosen: IntArray) -> tuple[IntArray, IntArray]:
        return nested_ranks(equations.of_curves(chosen), int(sizes[chosen[0]]))

    batches = _alike(small, np.stack([sizes, images]), equations.row_counts, columns)
    across = _independent_points(equations, small)
    for chosen, (own, both) in zip(batches, in_threads(ranks, batches), strict=True):
        for k, one, all_ in zip(chosen.tolist(), own.tolist(), both.tolist(), strict=True):
            found[k] = FeatureRank(one, all_ - one, int(across[k]))
    return found


def _independent_points(equations: OwnEquations, curves: IntArray) -> IntArray:
    """Sum over images of the rank of the equations across every curve, (nc,); 0 of those that are not asked for."""
    of_track, points = equations.tracks
    asked = np.zeros(len(equations.coefficient_counts), dtype=bool)
    asked[curves] = True
    sizes = 3 * equations.coefficient_counts[of_track]
    batches = _alike(np.flatnonzero(asked[of_track]), sizes[None], points.counts, sizes)
    found = np.zeros(len(asked), dtype=np.int64)
    ranks = in_threads(lambda tracks: numerical_ranks(equations.across(tracks)), batches)
    for tracks, own in zip(batches, ranks, strict=True):
        np.add.at(found, of_track[tracks], own)
    return found


def point_ranks(equations: OwnEquations) -> list[FeatureRank | None]:
    """Of every object point; all None where there are very many."""
    rays = equations.rays_of_point.counts
    found: list[FeatureRank | None] = [None] * len(rays)
    if len(rays) > MOST_FEATURES:
        return found
    batches = _alike(np.arange(len(rays)), rays[None], 2 * rays + 3, 3 + 6 * rays)
    for chosen in batches:
        own, both = nested_ranks(equations.of_points(chosen), 3)
        for k, one, all_ in zip(chosen.tolist(), own.tolist(), both.tolist(), strict=True):
            found[k] = FeatureRank(one, all_ - one, None)
    return found


def image_ranks(equations: OwnEquations) -> IntArray:
    """Rank of the equations of every image over its orientation, features known, (m,)."""
    rows, owned = equations.of_images()
    found = np.zeros(len(owned.counts), dtype=np.int64)
    for images in _alike(
        np.arange(len(found)), np.zeros((1, len(found))), owned.counts, np.full(len(found), 6)
    ):
        row, place, line = owned.rows(images)
        matrices = np.zeros((len(images), int(owned.counts[images].max()), 6))
        matrices[place, line] = rows[row]
        found[images] = numerical_ranks(matrices)
    return found


def _alike(members: IntArray, kinds: NDArray[Any], rows: IntArray, columns: IntArray) -> list[IntArray]:
    """Members in batches of the same kind, of nearly as many rows, that fit into the cache.

    Parameters
    ----------
    kinds : (q, n) what members of a batch have in common
    rows, columns : (n,) of the matrices
    """
    members = members[np.lexsort((rows[members], *kinds[:, members]))]
    batches, begin = [], 0
    kind, size = kinds[:, members], rows[members]
    while begin < len(members):
        same = (kind[:, begin:] == kind[:, begin, None]).all(axis=0) & (
            size[begin:] <= size[begin] + max(8, int(size[begin]) // 4)
        )
        number = len(same) if same.all() else int(np.argmin(same))
        largest = max(1, BATCH // max(1, int(size[begin + number - 1] * columns[members[begin]])))
        batches.append(members[begin : begin + min(number, largest)])
        begin += len(batches[-1])
    return batches
