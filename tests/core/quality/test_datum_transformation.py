"""Differences of orientations in the datum of the mean of their perspective centres."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.camera.rotation import (
    angles_from_rotation,
    rotation_from_vector,
    rotation_object_from_photo,
)
from splinebba_cli.core.network import RotationSequence
from splinebba_cli.core.quality.datum_transformation import centred_dispersion, datum_matrix

RNG = np.random.default_rng(3)
ANGLES = RNG.normal(0.0, 0.4, (5, 3))
POSITION = RNG.normal(0.0, 300.0, (5, 3)) + [5e5, 4e6, 800.0]
SEQUENCES: list[RotationSequence] = ["omega-phi-kappa", "phi-omega-kappa"] * 2 + ["omega-phi-kappa"]
ROTATION = np.array([rotation_object_from_photo(a, s) for a, s in zip(ANGLES, SEQUENCES, strict=True)])


def moved(step: float) -> np.ndarray:
    """What a small similarity about the mean of the centres does to angles and positions, column by column."""
    columns = []
    about = POSITION - POSITION.mean(axis=0)
    for k in range(7):
        small = np.zeros(7)
        small[k] = step
        turn = rotation_from_vector(small[None, 3:6])[0]
        angles = [angles_from_rotation(turn @ r, s) for r, s in zip(ROTATION, SEQUENCES, strict=True)]
        position = (1.0 + small[6]) * about @ turn.T + small[:3]
        columns.append(np.hstack([np.array(angles) - ANGLES, position - about]).ravel() / step)
    return np.array(columns).T


def test_datum_matrix_is_the_derivative() -> None:
    """Central differences: the step of 1e-5 leaves 1e-10 of the third derivative and 1e-11 of rounding."""
    expected = 0.5 * (moved(1e-5) + moved(-1e-5))
    assert datum_matrix(ROTATION, ANGLES, POSITION, SEQUENCES) == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_dispersions_do_not_depend_on_the_datum() -> None:
    """C + G D G' has the same centred dispersion as C for any D."""
    datum = datum_matrix(ROTATION, ANGLES, POSITION, SEQUENCES)
    root = RNG.normal(size=(30, 30)) * np.tile([1e-5] * 3 + [0.01] * 3, 5)[:, None]
    other = RNG.normal(size=(7, 7)) * np.array([0.1] * 3 + [1e-4] * 3 + [1e-4])[:, None]
    one = centred_dispersion(root @ root.T, datum)
    two = centred_dispersion(root @ root.T + datum @ other @ other.T @ datum.T, datum)
    sigma = np.sqrt(np.diag(one))
    assert np.abs((one - two) / np.outer(sigma, sigma)).max() < 1e-6
