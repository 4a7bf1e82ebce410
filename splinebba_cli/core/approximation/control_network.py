"""Parts of a network that orient its images: points alone, or control splines with points as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import ArcLengths, BoolArray, CurveObservations, IntArray, Network, Tangents

POINTS_NEEDED = 3
CONTROL_POINTS_NEEDED = 7  # measured points of control splines in every image: one more than its unknowns


def known_curves(network: Network) -> BoolArray:
    """Which curves have all their values held, (nc,)."""
    return np.array([bool((curve.sigma == 0.0).all()) for curve in network.curves], dtype=bool)


def control_network(network: Network, kept: BoolArray | None = None) -> tuple[Network, IntArray]:
    """The network without its curves that are not wholly known, and the measured curve points that stay, (n,).

    Arc lengths and tangents at points that stay go with them.

    Parameters
    ----------
    kept : (nc,) other curves that stay instead
    """
    known = known_curves(network) if kept is None else kept
    observed, arcs, tangents = network.curve_observations, network.arc_lengths, network.tangents
    rows = np.flatnonzero(known[observed.curve])
    curve_number, row_number = np.cumsum(known) - 1, np.full(len(observed), -1)
    row_number[rows] = np.arange(len(rows))
    kept_arcs, kept_tangents = row_number[arcs.first] >= 0, row_number[tangents.point] >= 0
    return (
        replace(
            network,
            curves=tuple(curve for curve, keep in zip(network.curves, known, strict=True) if keep),
            curve_observations=CurveObservations(
                observed.image[rows],
                curve_number[observed.curve[rows]].astype(np.int64),
                observed.photo_xy[rows],
                observed.sigma[rows],
                observed.location[rows],
                observed.segment[rows],
            ),
            arc_lengths=replace(
                arcs,
                first=row_number[arcs.first[kept_arcs]],
                second=row_number[arcs.second[kept_arcs]],
                length=arcs.length[kept_arcs],
                sigma=arcs.sigma[kept_arcs],
                simpson=arcs.simpson[kept_arcs],
                group=None,
                group_names=(),
            ),
            tangents=replace(
                tangents,
                point=row_number[tangents.point[kept_tangents]],
                direction=tangents.direction[kept_tangents],
                sigma=tangents.sigma[kept_tangents],
                directed=tangents.directed[kept_tangents],
                group=None,
                group_names=(),
            ),
        ),
        rows,
    )


def control_orients(network: Network) -> bool:
    """Whether control splines alone see enough of every free image, and there is something that they do not know."""
    known = known_curves(network)
    free = (network.images.prior_sigma != 0.0).any(axis=1)
    seen = np.bincount(
        network.curve_observations.image[known[network.curve_observations.curve]], minlength=len(free)
    )
    return bool(not known.all() and free.any() and (seen[free] >= CONTROL_POINTS_NEEDED).all())


def points_only(network: Network) -> Network:
    """The network without its curves."""
    none = np.zeros(0, dtype=np.int64)
    empty = CurveObservations(none, none, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), none)
    return replace(
        network,
        curves=(),
        curve_observations=empty,
        arc_lengths=ArcLengths.none(),
        tangents=Tangents.none(),
    )
