"""A consistent state at which equations, unknowns and rank of a network are counted.

The rank of a design is asked of the geometry, not of the quality of approximate values: every measured point lies
on its curve, at a location of its own,

    xy = p(X(u)),   u an unknown,

so that the residual along the curve is 0 and one of its two equations takes up its location.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import location_bounds
from splinebba_cli.core.state import Prepared, State

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)  # multiples of it modulo 1 are all different and evenly spread


@dataclass(frozen=True)
class StructuralState:
    """A network whose curve points are measured exactly at their locations."""

    prepared: Prepared
    state: State
    held: IntArray  # measured curve points that have no location unknown


def structural_state(prepared: Prepared, state: State) -> StructuralState:
    """Locations of all measured curve points and the photo coordinates that they imply.

    Given locations are used as given.  Others are searched; what runs into the bounds of the curve, as rough
    approximate values make it do, is spread over its domain, one place for every point: points that share a place
    would repeat an equation.

    Parameters
    ----------
    state : State
        Approximate values, locations NaN where not given.

    Raises
    ------
    FloatingPointError
        If a curve point lies behind a camera.
    """
    low, high = location_bounds(prepared)
    location = _locations(prepared, state, low, high)
    found = replace(state, location=location)
    xy = _projected(prepared, found)
    rays = replace(prepared.curve_rays, xy=xy)
    return StructuralState(replace(prepared, curve_rays=rays), found, np.flatnonzero(low >= high))


def _locations(prepared: Prepared, state: State, low: FloatArray, high: FloatArray) -> FloatArray:
    """Given, searched, spread, or held locations, (n,)."""
    given = np.isfinite(state.location)
    room = low < high
    if (given | ~room).all():
        return np.where(room, state.location, low)
    searched = search_locations(prepared, state).location
    beyond = ~np.isfinite(searched) | (searched <= low) | (searched >= high)
    observed, curves = prepared.network.curve_observations, prepared.curves
    begin = np.maximum(low, curves.first[observed.curve])
    end = np.minimum(high, curves.last[observed.curve])
    share = np.mod(0.5 + GOLDEN * np.arange(len(observed)), 1.0)
    inside = np.where(beyond, begin + share * (end - begin), searched)
    return np.where(room, np.where(given, state.location, inside), low)


def _projected(prepared: Prepared, state: State) -> FloatArray:
    """Photo coordinates of the curves at the present locations, (n, 2) mm."""
    observed = prepared.network.curve_observations
    image = observed.image
    xyz = prepared.curves.evaluate(state.coefficients, observed.curve, state.location)[0]
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    if not np.isfinite(xy).all():
        raise FloatingPointError("a curve point lies behind a camera")
    return xy
