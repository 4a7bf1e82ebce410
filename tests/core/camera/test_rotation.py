"""Rotations: both sequences against scipy, round trips up to phi = 90 degrees, rotation vectors, angle Jacobian."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from splinebba_cli.core.camera.rotation import (
    angle_jacobian,
    angles_from_rotation,
    cross_matrix,
    rotation_from_vector,
    rotation_object_from_photo,
    wrap_angle,
)
from splinebba_cli.core.network import FloatArray, RotationSequence

SEQUENCES: list[RotationSequence] = ["omega-phi-kappa", "phi-omega-kappa"]
both = pytest.mark.parametrize("sequence", SEQUENCES)
STEP = 1e-25
LIMITED = {"omega-phi-kappa": 1, "phi-omega-kappa": 0}  # the second rotation of the sequence


def angles(sequence: RotationSequence, count: int = 60) -> FloatArray:
    """Omega, phi, kappa; the second rotation of the sequence within 90 degrees."""
    out = np.random.default_rng(1).uniform(-np.pi, np.pi, (count, 3))
    out[:, LIMITED[sequence]] /= 2.0
    return out


@both
def test_matrices_equal_scipy(sequence: RotationSequence) -> None:
    a = angles(sequence)
    axes, order = ("XYZ", [0, 1, 2]) if sequence == "omega-phi-kappa" else ("YXZ", [1, 0, 2])
    expected = Rotation.from_euler(axes, a[:, order]).as_matrix()
    np.testing.assert_allclose(rotation_object_from_photo(a, sequence), expected, rtol=0.0, atol=1e-14)


@both
def test_angles_come_back(sequence: RotationSequence) -> None:
    a = angles(sequence)
    again = angles_from_rotation(rotation_object_from_photo(a, sequence), sequence)
    np.testing.assert_allclose(wrap_angle(again - a), 0.0, rtol=0.0, atol=1e-12)


@both
@pytest.mark.parametrize("short_of", [1e-3, 1e-5, 1e-7, 1e-9, 0.0, -1e-6])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_rotation_comes_back_near_ninety_degrees(
    sequence: RotationSequence, short_of: float, sign: float
) -> None:
    """Angles are ambiguous there; the rotation that they stand for is not.

    cos(phi) down to the square root of rounding is all that the other two angles are read from: 1e-16 / 1e-8 = 1e-8.
    """
    a = angles(sequence, 20)
    a[:, LIMITED[sequence]] = sign * (np.pi / 2.0 - short_of)
    rotation = rotation_object_from_photo(a, sequence)
    found = angles_from_rotation(rotation, sequence)
    assert np.isfinite(found).all()
    again = rotation_object_from_photo(found, sequence)
    np.testing.assert_allclose(again, rotation, rtol=0.0, atol=1e-7 if abs(short_of) < 1e-6 else 1e-12)


@both
def test_angle_jacobian_equals_the_complex_step(sequence: RotationSequence) -> None:
    """R(a + da) = R(a) exp([J da]x): the vector of R' dR / da, from complex angles."""
    a = angles(sequence)
    found = angle_jacobian(a, sequence)
    rotation = rotation_object_from_photo(a, sequence)
    for k in range(3):
        moved = a.astype(complex)
        moved[:, k] += 1j * STEP
        derivative = np.imag(rotation_object_from_photo(moved, sequence)) / STEP
        skew = np.swapaxes(rotation, 1, 2) @ derivative
        np.testing.assert_allclose(skew, cross_matrix(found[:, :, k]), rtol=0.0, atol=1e-12)


def test_rotation_vectors_equal_scipy() -> None:
    """All lengths, through the switch to the series."""
    generator = np.random.default_rng(5)
    direction = generator.normal(size=(60, 3))
    theta = direction / np.linalg.norm(direction, axis=1)[:, None] * np.logspace(-12, 0.45, 60)[:, None]
    expected = Rotation.from_rotvec(theta).as_matrix()
    np.testing.assert_allclose(rotation_from_vector(theta), expected, rtol=0.0, atol=3e-15)
    np.testing.assert_array_equal(rotation_from_vector(np.zeros((1, 3))), np.eye(3)[None])


def test_rotation_vectors_differentiate_to_the_cross_matrix() -> None:
    theta = 1j * STEP * np.eye(3)
    derivative = np.imag(rotation_from_vector(theta)) / STEP
    np.testing.assert_array_equal(derivative, cross_matrix(np.eye(3)))


def test_cross_matrix_and_wrapping() -> None:
    generator = np.random.default_rng(6)
    v, w = generator.normal(size=(2, 10, 3))
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", cross_matrix(v), w), np.cross(v, w), rtol=0.0, atol=1e-15
    )
    np.testing.assert_allclose(wrap_angle(np.array([3.5, -3.5, 7.0, 0.1])), [3.5 - 2 * np.pi, 2 * np.pi - 3.5,
                                                                              7.0 - 2 * np.pi, 0.1])  # fmt: skip
    assert wrap_angle(np.array([np.pi]))[0] == -np.pi
