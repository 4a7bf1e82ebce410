"""Splines through places with dispersions."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.shapes.place_fit import Places, fit_on_knots, fit_places, lateral_weights
from splinebba_cli.core.network import FloatArray

SIGMA = 0.05


def places(xyz: FloatArray, sigma: float = SIGMA, spacing: float = 1.0) -> Places:
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])
    dispersion = np.broadcast_to(sigma**2 * np.eye(3), (len(xyz), 3, 3)).copy()
    return Places(along, xyz, dispersion, spacing=spacing)


def noisy_line(count: int = 60, seed: int = 1) -> FloatArray:
    line = np.column_stack([np.arange(count), 0.3 * np.arange(count), np.full(count, 5.0)])
    return line + np.random.default_rng(seed).normal(0.0, SIGMA, (count, 3))


def wave(count: int = 80) -> FloatArray:
    x = np.arange(count, dtype=float)
    return np.column_stack([x, 6.0 * np.sin(x / 12.0), 0.1 * x])


def test_a_straight_edge_needs_no_inner_knot() -> None:
    assert len(fit_places(places(noisy_line()), 2.0).knots) == 2


def test_knots_are_inserted_until_the_bends_are_followed() -> None:
    fit = fit_places(places(wave()), 2.0)
    assert 4 <= len(fit.knots) <= 20
    assert np.median(fit.distance) < 1.0


def test_a_place_far_off_does_not_pull_the_curve() -> None:
    xyz = noisy_line()
    xyz[30, 2] += 5.0
    fit = fit_places(places(xyz), 2.0)
    assert len(fit.knots) == 2
    assert abs(fit.evaluate(np.array([31.0]))[0, 2] - 5.0) < 3 * SIGMA


def test_places_count_by_their_dispersion() -> None:
    """Heights of every second place are known ten times worse and 1 m wrong."""
    xyz = noisy_line()
    own = places(xyz)
    own.dispersion[::2, 2, 2] = (20 * SIGMA) ** 2
    xyz[::2, 2] += 1.0
    fit = fit_on_knots(own, np.array([0.0, own.location[-1]]))
    assert np.abs(fit.evaluate(np.linspace(5.0, 50.0, 9))[:, 2] - 5.0).max() < 2 * SIGMA


def test_places_that_say_nothing_do_not_bend_a_bridge() -> None:
    """Between two straight ends, places 15 m off whose sigma is 20 m: the smoothest continuation is straight on."""
    xyz = noisy_line()
    own = places(xyz)
    own.dispersion[20:40] = 20.0**2 * np.eye(3)
    xyz[20:40, 2] += 15.0
    fit = fit_on_knots(own, own.location[[0, 10, 20, 24, 28, 32, 36, 40, 50, 59]])
    assert np.abs(fit.evaluate(own.location[24:36])[:, 2] - 5.0).max() < 3.0


def test_weights_are_blind_along_the_curve() -> None:
    tangent = np.array([[0.6, 0.0, 0.8]])
    weight = lateral_weights(tangent, np.diag([4.0, 1.0, 9.0])[None])
    assert weight[0] @ tangent[0] == pytest.approx(np.zeros(3), abs=1e-12)
    assert weight[0][1, 1] == pytest.approx(1.0)
