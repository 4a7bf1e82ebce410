"""Brown distortion and affinity: single terms, Jacobian against the complex step, the inverse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.camera.distortion import corrected_photo_xy, measured_photo_xy
from splinebba_cli.core.network import Camera, FloatArray
from tests.core.observations import complex_step
from tests.core.observations.random_network import camera_of

NONE = Camera("c", 100.0, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2))


def places(count: int = 30) -> FloatArray:
    """Photo coordinates over a format of 40 mm."""
    return np.random.default_rng(4).uniform(-20.0, 20.0, (count, 2))


@pytest.mark.parametrize(
    ("camera", "expected"),
    [
        (NONE, (3.0, -4.0)),
        (replace(NONE, principal_point_mm=np.array([0.5, -1.0])), (2.5, -3.0)),
        (replace(NONE, radial=np.array([1e-3, 0.0, 0.0])), (3.0 * 1.025, -4.0 * 1.025)),
        (replace(NONE, radial=np.array([0.0, 1e-4, 0.0])), (3.0 * 1.0625, -4.0 * 1.0625)),
        (replace(NONE, radial=np.array([0.0, 0.0, 1e-5])), (3.0 * 1.15625, -4.0 * 1.15625)),
        (replace(NONE, decentring=np.array([1e-2, 0.0])), (3.0 + 0.43, -4.0 - 0.24)),
        (replace(NONE, decentring=np.array([0.0, 1e-2])), (3.0 - 0.24, -4.0 + 0.57)),
        (replace(NONE, affinity=np.array([0.1, 0.0])), (3.3, -4.0)),
        (replace(NONE, affinity=np.array([0.0, 0.1])), (2.6, -4.0)),
    ],
    ids=["none", "principal-point", "k1", "k2", "k3", "p1", "p2", "b1", "b2"],
)
def test_every_term_by_hand(camera: Camera, expected: tuple[float, float]) -> None:
    """At (3, -4), r = 5: corrected = measured + Brown(measured)."""
    corrected, _ = corrected_photo_xy(camera, np.array([[3.0, -4.0]]))
    np.testing.assert_allclose(corrected[0], expected, rtol=1e-13)


@pytest.mark.parametrize("seed", range(5))
def test_values_and_jacobian_equal_the_complex_step(seed: int) -> None:
    camera = camera_of(0, np.random.default_rng(seed))
    corrected, jacobian = corrected_photo_xy(camera, places())
    for k, xy in enumerate(places()):
        exact = complex_step.jacobian(lambda x: complex_step.corrected(camera, x), xy)
        np.testing.assert_allclose(corrected[k], complex_step.corrected(camera, xy), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(jacobian[k], exact, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_the_inverse(seed: int) -> None:
    """Corrected to measured and back, distortions of up to some millimetres."""
    camera = camera_of(0, np.random.default_rng(seed))
    corrected, _ = corrected_photo_xy(camera, places())
    assert np.abs(corrected - places()).max() > 0.1
    np.testing.assert_allclose(measured_photo_xy(camera, corrected), places(), rtol=0.0, atol=1e-11)


def test_no_points() -> None:
    assert corrected_photo_xy(NONE, np.zeros((0, 2)))[0].shape == (0, 2)
    assert measured_photo_xy(NONE, np.zeros((0, 2))).shape == (0, 2)
