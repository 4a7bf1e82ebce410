"""Corners stay where they are when a natural spline gets other knots."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.approximation.knot_spacing import respaced
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters, supported_knots_between
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve

CORNER = np.array([10.0, 0.0, 1.0])


def angle() -> Curve:
    """Two straight sides of ten metres, knots every two."""
    along = np.arange(0.0, 11.0, 2.0)
    first = np.column_stack([along, 0.0 * along, np.ones(6)])
    values = np.vstack([first, np.column_stack([np.full(5, 10.0), along[1:], np.ones(5)])])
    return Curve("angle", "tie", "natural_cubic", values, np.full(values.shape, np.inf), breaks=(5,))


def test_corners_are_found_among_other_knots() -> None:
    curve = angle()
    corners = corner_parameters(curve, basis_of(curve))
    np.testing.assert_allclose(corners, [10.0])
    assert breaks_among(np.array([0.0, 3.0, 7.0, 10.0, 20.0]), corners) == (3,)
    assert breaks_among(np.array([10.0, 12.0, 20.0]), corners) == ()


def test_a_corner_stays_though_nothing_supports_its_segments() -> None:
    number = np.array([9, 9, 0, 0, 1, 9])
    np.testing.assert_array_equal(supported_knots_between(number, (3,)), [0, 1, 3, 6])
    assert 3 not in supported_knots_between(number, ())


def test_sides_are_respaced_and_the_corner_kept() -> None:
    curve = angle()
    basis = basis_of(curve)
    for smooth in (False, True):
        new = respaced(curve, basis, curve.values, np.linspace(0.0, 20.0, 60), 5.0, smooth)
        assert new.breaks == (2,)
        np.testing.assert_allclose(new.values[2], CORNER, atol=1e-6)
        np.testing.assert_allclose(np.diff(np.asarray(new.knot_parameters)), 5.0, atol=1e-6)
        sampled = basis_of(new).evaluate([7.5, 12.5], new.values)
        np.testing.assert_allclose(sampled, [[7.5, 0.0, 1.0], [10.0, 2.5, 1.0]], atol=1e-6)
