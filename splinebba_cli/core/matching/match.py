"""match(network): orientations, labels and shapes for points that nobody has labelled, in order."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.matching.candidates import find_candidates
from splinebba_cli.core.matching.matches import Matches, MatchResult, Reason
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import CurveObservations, IntArray, Network, select_rows
from splinebba_cli.core.state import State, initial_coefficients, prepare

_log = logging.getLogger(__name__)

GATE_SIGMA = 4.0


def match(
    network: Network, settings: MatchSettings | None = None, *, observer: Observer | None = None
) -> MatchResult:
    """Match the unlabelled points of a network.

    Parameters
    ----------
    settings : MatchSettings, optional
    observer : called after every iteration of the adjustments inside

    Returns
    -------
    MatchResult
    """
    settings = settings or MatchSettings()
    _log.info("matching")
    prepared = prepare(network)
    images = network.images
    state = State(
        images.rotation, images.position, initial_coefficients(prepared), network.points.xyz,
        network.curve_observations.location,
    )  # fmt: skip
    scene = Scene.of(network, state, prepared)
    radius = GATE_SIGMA * network.unlabelled.sigma.max(axis=1)
    near = find_candidates(scene, radius)
    first = np.unique(near.point, return_index=True)[1]
    count = len(network.unlabelled)
    curve, location = np.full(count, -1), np.full(count, np.nan)
    distance, reason = np.full(count, np.inf), np.full(count, int(Reason.FAR))
    curve[near.point[first]], location[near.point[first]] = near.curve[first], near.location[first]
    distance[near.point[first]] = np.linalg.norm(near.offset[first], axis=1)
    reason[near.point[first]] = Reason.MATCHED
    matches = Matches(curve, location, distance, np.full(count, np.inf), reason)
    return MatchResult(
        network=with_labels(network, curve, location),
        given=network,
        matches=matches,
        oriented=np.zeros(len(images.ids), dtype=bool),
        eop_dispersion=np.full((len(images.ids), 6, 6), np.nan),
    )


def with_labels(network: Network, curve: IntArray, location: np.ndarray) -> Network:
    """The network with labelled points among its curve observations, behind those that it had.

    Parameters
    ----------
    curve : (n,) curve of every unlabelled point, -1: stays unlabelled
    location : (n,) u
    """
    points, old = network.unlabelled, network.curve_observations
    rows = np.flatnonzero(curve >= 0)
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
        np.vstack([old.sigma, points.sigma[rows]]),
        np.concatenate([old.location, location[rows]]),
        np.concatenate([old.segment, np.full(len(rows), -1)]),
        np.concatenate([old_group, len(names) + own_group[rows]]),
        (*names, *own_names),
        excluded,
    )  # fmt: skip
    rest = select_rows(points, np.flatnonzero(curve < 0))
    return replace(network, curve_observations=labelled, unlabelled=rest)
