"""The state from which an adjustment starts: given values first, the rest from the measurements."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.approximation.orientation import approximate_orientations
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State, initial_coefficients
from splinebba_cli.errors import SingularNetworkError


def starting_state(prepared: Prepared) -> tuple[State, tuple[Problem, ...]]:
    """Approximate values of all unknowns; locations still unknown (NaN) where not given.

    Raises
    ------
    SingularNetworkError
        Naming every image and point without an approximate value.
    """
    network = prepared.network
    found = approximate_orientations(network)
    missing = [
        Problem(
            "SBB503",
            "error",
            f"image `{network.images.ids[k]}` has no approximate orientation: {reason}",
            f"image `{network.images.ids[k]}`",
            "give an approximate orientation, or measure at least four control points in it",
        )
        for k, reason in sorted(found.unresolved.items())
    ]
    observed = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
    unknown = np.flatnonzero(~np.isfinite(found.xyz).all(axis=1))
    if not missing:
        missing += [_point_without_position(network, int(k), int(observed[k])) for k in unknown]
    if missing:
        raise SingularNetworkError(missing)
    weak = tuple(
        Problem(
            "SBB504",
            "info",
            f"point `{network.points.ids[k]}` is intersected at a small angle",
            f"point `{network.points.ids[k]}`",
            "measure it in an image from another direction",
        )
        for k in np.flatnonzero(found.weak_points)
    )
    state = State(
        rotation=found.rotation,
        position=found.position,
        coefficients=initial_coefficients(prepared),
        xyz=found.xyz,
        location=network.curve_observations.location.copy(),
    )
    return state, weak


def _point_without_position(network: Network, point: int, rays: int) -> Problem:
    id_ = network.points.ids[point]
    if rays < 2:
        reason = f"{rays} ray{'s' if rays != 1 else ''}"
        help = "measure it in a second image, give its coordinates, or remove it"
    else:
        reason = "its rays do not intersect in front of the images"
        help = "look at its measurements and at the orientations of these images; or give its coordinates, or remove it"
    return Problem(
        "SBB521",
        "error",
        f"point `{id_}` cannot be intersected: {reason}",
        f"point `{id_}`",
        help,
    )
