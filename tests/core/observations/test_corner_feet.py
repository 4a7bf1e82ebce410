"""Foot points at corners, against places beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.matching.match import with_labels
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.observations.location_search import search_locations, squared_distance
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare
from tests.core.matching.fragments.small_scenes import scene, straight
from tests.core.matching.shapes.edges import curve_through, state_of
from tests.reference_data import with_fixed_images

HALF = 30


def roof_network() -> Network:
    """All points of a roof edge on one spline with a corner."""
    first = straight((-30.0, 0.0, 20.0), (1.0, 0.3, 0.05), HALF + 1)
    second = straight(tuple(first[-1]), (-0.3, 1.0, 0.0), HALF + 1)[1:]
    block = scene([np.vstack([first, second])])
    curve = replace(curve_through(block.curves[0], "roof", 10), breaks=(3,))
    count = len(block.network.unlabelled)
    return with_labels(
        replace(block.network, curves=(curve,)), np.zeros(count, dtype=np.int64), np.full(count, np.nan)
    )


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return prepare(roof_network())


def state(prepared: Prepared, location: FloatArray, inward: float = 0.0) -> State:
    """The true curve, or one whose corner lies so many metres inside of the measured one."""
    coefficients = initial_coefficients(prepared)
    sides = coefficients[[0, -1]] - coefficients[3]
    coefficients[3] += inward * (sides / np.linalg.norm(sides, axis=1, keepdims=True)).sum(axis=0)
    return replace(state_of(prepared.network), coefficients=coefficients, location=location)


def unknown(prepared: Prepared) -> FloatArray:
    return np.full(len(prepared.network.curve_observations), np.nan)


def test_points_outside_of_a_corner_are_on_it(prepared: Prepared) -> None:
    found = search_locations(prepared, state(prepared, unknown(prepared), inward=1.0))
    corner = prepared.curves.bases[0].break_points[3]
    held = held_locations(prepared, found.location)
    on_corner = np.flatnonzero(found.location == corner)
    assert len(on_corner) > 3
    assert set(on_corner) <= set(held.tolist())
    square = squared_distance(prepared, found)
    for beside in (-0.05, -0.01, 0.01, 0.05):  # metres: nothing near is nearer
        there = np.where(found.location == corner, corner + beside, found.location)
        near = squared_distance(prepared, replace(found, location=there))
        assert (near[on_corner] > square[on_corner]).all()


def test_every_other_point_is_at_its_foot(prepared: Prepared) -> None:
    found = search_locations(prepared, state(prepared, unknown(prepared), inward=1.0))
    square = squared_distance(prepared, found)
    for beside in (-0.05, 0.05):
        near = squared_distance(prepared, replace(found, location=found.location + beside))
        assert (near >= square - 1e-9).all()


def test_points_leave_a_corner_that_moves_away(prepared: Prepared) -> None:
    corner = prepared.curves.bases[0].break_points[3]
    found = search_locations(prepared, state(prepared, unknown(prepared)))
    near = (np.abs(found.location - corner) < 4.0) & (np.abs(found.location - corner) > 0.5)
    on_it = replace(found, location=np.where(near, corner, found.location))
    again = search_locations(prepared, on_it)
    assert near.sum() > 8
    np.testing.assert_allclose(again.location[near], found.location[near], atol=1e-6)


def test_a_spline_with_a_corner_is_adjusted() -> None:
    result = adjust(with_fixed_images(roof_network()))
    assert result.converged
    assert 0.85 < result.statistics.sigma0 < 1.15
