"""Curves of the project whose matched points show two edges side by side."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.shapes.double_edges import clusters_beside
from splinebba_cli.core.matching.shapes.new_curve_problems import two_edges_problem
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem


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
    order = np.argsort(curve, kind="stable")
    curves, first = np.unique(curve[order], return_index=True)
    found = []
    for k, own in zip(curves.tolist(), np.split(order, first)[1:], strict=True):
        clusters = clusters_beside(location[own], residual[own], names[own])
        if clusters is not None:
            found.append(two_edges_problem(network, k, clusters))
    return found
