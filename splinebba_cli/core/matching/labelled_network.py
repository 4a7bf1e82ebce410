"""Labels made observations: unlabelled points of a network that become measured points of curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import CurveObservations, FloatArray, IntArray, Network, select_rows


def with_labels(
    network: Network, curve: IntArray, location: FloatArray, sigma_factor: FloatArray | None = None
) -> Network:
    """The network with labelled points among its curve observations, behind those that it had.

    Parameters
    ----------
    curve : (n,) curve of every unlabelled point, -1: stays unlabelled
    location : (n,) u
    sigma_factor : (n,) of the standard deviations of these points
    """
    points, old = network.unlabelled, network.curve_observations
    rows = np.flatnonzero(curve >= 0)
    factor = np.ones(len(points)) if sigma_factor is None else sigma_factor
    names = old.group_names or ("",)
    own_names = points.group_names or ("matched",)
    old_group = old.group if old.group is not None else np.zeros(len(old), dtype=np.int64)
    own_group = points.group if points.group is not None else np.zeros(len(points), dtype=np.int64)
    excluded = None
    if old.excluded is not None or points.excluded is not None:
        parts = [
            np.zeros(len(each), dtype=bool) if each.excluded is None else each.excluded
            for each in (old, points)
        ]
        excluded = np.concatenate([parts[0], parts[1][rows]])
    labelled = CurveObservations(
        np.concatenate([old.image, points.image[rows]]),
        np.concatenate([old.curve, curve[rows]]),
        np.vstack([old.photo_xy, points.photo_xy[rows]]),
        np.vstack([old.sigma, points.sigma[rows] * factor[rows, None]]),
        np.concatenate([old.location, location[rows]]),
        np.concatenate([old.segment, np.full(len(rows), -1)]),
        np.concatenate([old_group, len(names) + own_group[rows]]),
        (*names, *own_names),
        excluded,
    )  # fmt: skip
    rest = select_rows(points, np.flatnonzero(curve < 0))
    return replace(network, curve_observations=labelled, unlabelled=rest)
