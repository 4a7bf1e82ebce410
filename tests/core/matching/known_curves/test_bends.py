"""Directions beside curves that bend within the noise of a point."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.candidates.search import find_candidates
from splinebba_cli.core.matching.known_curves.bends import turns, turns_within_noise
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from tests.core.matching.known_curves.one_image import GOOD, MIDDLE, SIGMA_MM, control, network, seen

SCALE = 0.3  # mm in the image a metre


def turned(radius_sigma: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Turns at five points of an arc, from directions that are off by an angle; with and without regard to noise."""
    radius = radius_sigma * SIGMA_MM / SCALE
    at = np.linspace(0.0, 1.6 * np.pi, 25)
    arc = control([(radius * np.cos(a), radius * np.sin(a), -MIDDLE[2]) for a in at], "arc")
    given = network([arc], [], seen(arc, 5, 0.3, 0.7))
    scene = LoopContext.of(given, GOOD, None).first_scene
    near = find_candidates(scene, np.full(5, 0.1 * SIGMA_MM))
    direction = np.arctan2(near.tangent[:, 1], near.tangent[:, 0]) - angle
    return turns_within_noise(scene, near, direction, np.ones(len(near), dtype=bool)), turns(
        direction, near.tangent
    )


@pytest.mark.parametrize("angle", [-0.8, 0.05, 0.8])
def test_within_noise_a_narrow_bend_has_every_direction(angle: float) -> None:
    """Three sigma along an arc of a radius of three sigma turn by one radian."""
    found, plain = turned(3.0, angle)
    np.testing.assert_allclose(plain, angle, atol=1e-9)
    np.testing.assert_allclose(found, 0.0 if abs(angle) > 0.1 else angle, atol=1e-9)


def test_beyond_that_the_rest_counts() -> None:
    found, _ = turned(3.0, 1.4)
    np.testing.assert_allclose(found, 0.4, atol=0.02)


def test_a_gentle_bend_excuses_little() -> None:
    found, _ = turned(300.0, 0.8)
    np.testing.assert_allclose(found, 0.8 - 3.0 / 300.0, atol=0.002)


def test_unknown_directions_stay_unknown() -> None:
    found, _ = turned(3.0, np.nan)
    assert np.isnan(found).all()
