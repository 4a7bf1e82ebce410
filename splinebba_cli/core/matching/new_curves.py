"""Tie curves from chains that no curve of the network explains."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.candidates.search import find_candidates
from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.fragments.fragment_findings import fragment_problems
from splinebba_cli.core.matching.matches import BuiltCurve, Matches, Reason
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import build_curves
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State, initial_coefficients, prepare

_log = logging.getLogger(__name__)

NEAR = 10.0  # sigma, within which distances are looked at
NO_USE = (Reason.MATCHED, Reason.EXCLUDED, Reason.NOT_ORIENTED)


@dataclass(frozen=True)
class WithNewCurves:
    """The network with more curves, and the labels of its points."""

    network: Network
    matches: Matches
    built: tuple[BuiltCurve, ...]
    problems: tuple[Problem, ...]


def with_new_curves(
    network: Network, state: State, matches: Matches, settings: MatchSettings
) -> WithNewCurves:
    """Curves built from unmatched chains, behind those of the network.

    Parameters
    ----------
    state : orientations and points as they are known by now
    matches : of all unlabelled points with the curves of the network
    """
    rows = np.flatnonzero(~np.isin(matches.reason, NO_USE))
    fragments = build_fragments(network, state.rotation, state.position, settings, rows, state.xyz)
    new = build_curves(network, state, fragments, settings, rows)
    _log.info(
        "%d curves built from %d fragments, %d points linked",
        len(new.curves), len(fragments), np.count_nonzero(new.curve >= 0),
    )  # fmt: skip
    curve = np.where(new.curve >= 0, len(network.curves) + new.curve, new.on_given)
    linked = np.flatnonzero(curve >= 0)
    wider = replace(network, curves=(*network.curves, *new.curves))
    labelled = _relabelled(matches, linked, curve[linked], new.location[linked])
    return WithNewCurves(
        network=wider,
        matches=_with_distances(wider, state, labelled, linked),
        built=tuple(replace(each, curve=len(network.curves) + each.curve) for each in new.built),
        problems=(*_findings(network, state, fragments, rows), *new.problems),
    )


def _findings(network: Network, state: State, fragments: Sequence[Fragment], rows: IntArray) -> list[Problem]:
    """What is said of the chains; not which of them are left (SBB591), since more points are linked to new curves."""
    if not len(rows):
        return []
    found = fragment_problems(network, state.rotation, state.position, fragments, rows)
    return [problem for problem in found if problem.code != "SBB591"]


def _relabelled(matches: Matches, rows: IntArray, curve: IntArray, location: FloatArray) -> Matches:
    """Matches with other labels of some points."""
    labels, places, reason = matches.curve.copy(), matches.location.copy(), matches.reason.copy()
    labels[rows], places[rows], reason[rows] = curve, location, int(Reason.MATCHED)
    return replace(matches, curve=labels, location=places, reason=reason)


def _with_distances(network: Network, state: State, matches: Matches, rows: IntArray) -> Matches:
    """Distances of points from their new curves, and from the next ones, in sigma of the points."""
    prepared = prepare(network)
    scene = Scene.of(network, replace(state, coefficients=initial_coefficients(prepared)), prepared)
    near = find_candidates(scene, NEAR * scene.noise, rows)
    away = np.linalg.norm(np.einsum("kij,kj->ki", scene.whitening[near.point], near.offset), axis=1)
    own = near.curve == matches.curve[near.point]
    distance, runner_up = matches.distance.copy(), matches.runner_up.copy()
    distance[rows], runner_up[rows] = np.inf, np.inf
    np.minimum.at(distance, near.point[own], away[own])
    np.minimum.at(runner_up, near.point[~own], away[~own])
    return replace(matches, distance=distance, runner_up=runner_up)
