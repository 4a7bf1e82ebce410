"""Orientations that gross errors do not spoil, before curves of unknown shape take part.

As in the stages of the adjustment: what the points alone determine, without points what the control splines alone
determine; here with the shrinking scale of :mod:`~.graduated_weights`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.control_network import (
    POINTS_NEEDED,
    control_network,
    control_orients,
    points_only,
)
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.network import Network
from splinebba_cli.core.revision.graduated_weights import graduated
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork
from splinebba_cli.core.state import State, initial_coefficients, prepare
from splinebba_cli.errors import SingularNetworkError


def robust_orientation(network: Network, state: State, observer: Observer | None) -> State:
    """The state with the orientations (and points) of such a stage, or as it is where the network allows none.

    Parameters
    ----------
    network : of what takes part
    """
    if not network.settings.staged or not network.curves:
        return state
    if len(network.point_observations) >= POINTS_NEEDED:
        part = points_only(network)
        begin = replace(state, coefficients=np.zeros((0, 3)), location=np.zeros(0))
    elif control_orients(network):
        part, rows = control_network(network)
        begin = replace(
            state, coefficients=initial_coefficients(prepare(part)), location=state.location[rows]
        )
    else:
        return state
    try:
        alone = WeightedNetwork(prepare(part), begin, None, observer, "start")
        factor, after = graduated(alone, begin, np.ones(len(alone.listed)))
        found = alone.solve(factor, after)
    except (FloatingPointError, np.linalg.LinAlgError, SingularNetworkError):
        return state  # named by the joint adjustment
    if found is None:
        return state
    return replace(state, rotation=found.state.rotation, position=found.state.position, xyz=found.state.xyz)
