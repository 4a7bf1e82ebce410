"""Tie curves from chains that no curve of the network explains."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.matching.matches import BuiltCurve, Matches, Reason
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import build_curves
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State

_log = logging.getLogger(__name__)

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
    offset = len(network.curves)
    linked = new.curve >= 0
    _log.info(
        "%d curves built from %d fragments, %d points linked", len(new.curves), len(fragments), linked.sum()
    )
    return WithNewCurves(
        network=replace(network, curves=(*network.curves, *new.curves)),
        matches=replace(
            matches,
            curve=np.where(linked, offset + new.curve, matches.curve),
            location=np.where(linked, new.location, matches.location),
            reason=np.where(linked, int(Reason.MATCHED), matches.reason),
        ),
        built=tuple(replace(each, curve=offset + each.curve) for each in new.built),
        problems=new.problems,
    )
