"""Mutual exclusion: in one image a stretch of a curve is claimed once.

Where two runs of one image lie on the same stretch of a curve, both stay if both fit within noise: an edge may be
traced twice, or in overlapping pieces.  Else the run that fits better keeps the stretch, and the other one loses its
points there.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.known_curves.gates import Gated
from splinebba_cli.core.matching.known_curves.runs import Runs
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

BINS = 64.0  # of a curve: places that are compared
SAME = 1.5  # sigma: two traces of one edge keep closer to it in the mean
BETTER = 1.5  # times the distance of the winner, beyond which a run loses


def taken_points(gated: Gated, runs: Runs, label: IntArray, first: FloatArray, last: FloatArray) -> BoolArray:
    """Points (n,) whose stretch of a curve belongs to another run.

    Parameters
    ----------
    label : (n,) candidate of every point, -1: none
    first, last : (nc,) domains of the curves
    """
    taken = np.zeros(len(label), dtype=bool)
    points = np.flatnonzero(runs.of_point >= 0)
    points = points[runs.chain[runs.of_point[points]] >= 0]  # single points claim no stretch
    if not len(points):
        return taken
    candidate, run = label[points], runs.of_point[points]
    curve = gated.candidates.curve[candidate]
    share = (gated.candidates.location[candidate] - first[curve]) / (last[curve] - first[curve])
    place = np.floor(BINS * np.clip(share, 0.0, 1.0 - 1e-9)).astype(np.int64)
    cell = (runs.image[run] * len(first) + curve) * int(BINS) + place
    distance = _distance(gated, candidate)
    _, cell = np.unique(cell, return_inverse=True)
    key = cell * len(runs.count) + run
    kinds, group = np.unique(key, return_inverse=True)
    mean = np.bincount(group, distance) / np.bincount(group)
    of_cell, of_run = kinds // len(runs.count), kinds % len(runs.count)
    # the usual distance of the whole run decides, so that one run wins along the stretch
    usual = np.bincount(run, distance, minlength=len(runs.count)) / np.maximum(
        np.bincount(run, minlength=len(runs.count)), 1
    )
    best = np.full(int(of_cell.max()) + 1, np.inf)
    np.minimum.at(best, of_cell, usual[of_run])
    loses = (usual[of_run] > BETTER * best[of_cell] + 0.5) & (np.maximum(mean, usual[of_run]) > SAME)
    taken[points] = loses[group]
    return taken


def _distance(gated: Gated, candidate: IntArray) -> FloatArray:
    """Distance across over the sigma of the point alone, (q,)."""
    return np.asarray(np.abs(gated.across[candidate]) / np.sqrt(np.maximum(gated.noise[candidate], 1e-300)))
