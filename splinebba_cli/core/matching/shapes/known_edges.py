"""Curves of the project whose matched points show two edges side by side."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.shapes.double_edges import APART, FEWEST, clusters_beside
from splinebba_cli.core.matching.shapes.new_curve_problems import two_edges_problem
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.row_groups import split_by


def double_edge_problems(
    network: Network, curve: IntArray, location: FloatArray, residual: FloatArray, image: IntArray, chain: IntArray
) -> list[Problem]:  # fmt: skip
    """SBB598 for every curve of the project whose points lie on two sides of it.

    Parameters
    ----------
    curve, location, image, chain : (n,) of matched points; chain -1: single points, those of an image count together
    residual : (n,) across, in sigma, with the sense of ascending locations
    """
    names = np.where(chain >= 0, chain, -1 - image)
    rows = split_by(curve, len(network.curves))
    found = []
    for k in _spread(curve, residual, names).tolist():
        own = rows[k]
        clusters = clusters_beside(location[own], residual[own], names[own])
        if clusters is not None:
            found.append(two_edges_problem(network, k, clusters))
    return found


def _spread(curve: IntArray, residual: FloatArray, names: IntArray) -> IntArray:
    """Curves whose chains lie far enough apart in the median for two edges; all chains at once."""
    order = np.lexsort((residual, names, curve))
    new = (np.diff(curve[order], prepend=-1) != 0) | (
        np.diff(names[order], prepend=names.min(initial=0) - 1) != 0
    )
    start = np.flatnonzero(new)
    size = np.diff(np.append(start, len(order)))
    median = 0.5 * (residual[order[start + (size - 1) // 2]] + residual[order[start + size // 2]])
    owner, enough = curve[order[start]], size >= FEWEST
    low, high = (
        np.full(int(curve.max(initial=0)) + 1, np.inf),
        np.full(int(curve.max(initial=0)) + 1, -np.inf),
    )
    np.minimum.at(low, owner[enough], median[enough])
    np.maximum.at(high, owner[enough], median[enough])
    return np.flatnonzero(high - low >= APART)
