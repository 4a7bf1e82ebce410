"""Cofactors and redundancy numbers from the selected inverse against the dense inverse of the whole system.

The dense inverse comes from a QR factorisation of the design matrix with columns of unit length, whose condition
number is about 1e3; the block Cholesky works with its square: 1e6 times rounding leaves nine digits.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.joint_cofactors import point_cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.redundancy import RedundancyNumbers, redundancy_numbers
from tests.core.small_networks import DenseSystem, dense_system, mixed_network, solved

TOLERANCE = 1e-9


@cache
def systems() -> tuple[Cofactors, DenseSystem, FloatArray]:
    """The selected and the dense inverse at the solution of a mixed network."""
    found = solved(mixed_network()[0])
    dense = dense_system(found.assembler, found.solution.linearization)
    return Cofactors(found.assembler, found.solution), dense, dense.inverse


def numbers() -> RedundancyNumbers:
    """Redundancy numbers of the mixed network."""
    cofactors = systems()[0]
    return redundancy_numbers(cofactors, linked_cofactors(cofactors))


def scaled(difference: FloatArray, rows: FloatArray, columns: FloatArray) -> float:
    """Largest difference of blocks (..., p, q) in units of the standard deviations (..., p) and (..., q)."""
    scale = (
        np.where(rows > 0.0, rows, 1.0)[..., :, None] * np.where(columns > 0.0, columns, 1.0)[..., None, :]
    )
    return float(np.abs(difference / scale).max())


def sigma_of(inverse: FloatArray) -> FloatArray:
    return np.sqrt(np.diag(inverse))


def test_orientations() -> None:
    cofactors, _, inverse = systems()
    sigma = sigma_of(inverse)
    for image, block in enumerate(cofactors.images):
        place = slice(6 * image, 6 * image + 6)
        assert scaled(block - inverse[place, place], sigma[place], sigma[place]) < TOLERANCE
    assert (cofactors.images[2] == 0.0).all() and (cofactors.images[3, 5] == 0.0).all()


def test_windows_of_coefficients() -> None:
    """The 12 x 12 blocks of all curve segments, and those under the conditions."""
    cofactors, _, inverse = systems()
    assembler = cofactors.assembler
    sigma, unknown = sigma_of(inverse), assembler.layout.unknown_of_coefficient
    for columns in (assembler.prepared.curves.columns, assembler.coefficient_rows.columns):
        for window, block in zip(columns, cofactors.coefficient_windows(columns), strict=True):
            place = (unknown[window][:, None] + np.arange(3)).ravel()
            assert scaled(block - inverse[np.ix_(place, place)], sigma[place], sigma[place]) < TOLERANCE


def test_points_and_their_images() -> None:
    cofactors, _, inverse = systems()
    layout, sigma = cofactors.assembler.layout, sigma_of(inverse)
    observed = cofactors.assembler.prepared.network.point_observations
    place_of = layout.unknown_of_point
    assert (layout.point_mask[0] == [1.0, 1.0, 0.0]).all() and len(layout.kept_points) == 5
    for point, block in enumerate(cofactors.points.own):
        place = place_of[point]
        assert scaled(block - inverse[np.ix_(place, place)], sigma[place], sigma[place]) < TOLERANCE
    for row, (image, point) in enumerate(zip(observed.image, observed.point, strict=True)):
        rows, columns = np.arange(6 * image, 6 * image + 6), place_of[point]
        difference = cofactors.points.with_image[row] - inverse[np.ix_(rows, columns)]
        assert scaled(difference, sigma[rows], sigma[columns]) < TOLERANCE


@pytest.mark.parametrize(
    "kind",
    ["curve_rows", "image_points", "distances", "orientation_priors", "point_priors", "coefficient_rows"],
)
def test_redundancy_numbers_of_every_kind(kind: str) -> None:
    """1 - diag(A Q A') in whitened units."""
    cofactors, dense, _ = systems()
    at = cofactors.solution.linearization
    found = {
        "curve_rows": numbers().curve_rows,
        "image_points": numbers().image_points.ravel(),
        "distances": numbers().distances,
        "orientation_priors": numbers().orientation_priors[at.orientation_priors.active],
        "point_priors": numbers().point_priors[cofactors.assembler.point_inverse_sigma > 0.0],
        "coefficient_rows": numbers().coefficient_rows,
    }
    begin = 0
    for name, values in found.items():
        if name == kind:
            assert len(values) > 0
            expected = dense.redundancy_numbers[begin : begin + len(values)]
            np.testing.assert_allclose(values, expected, rtol=0.0, atol=TOLERANCE)
        begin += len(values)
    assert begin == len(dense.design)


def test_several_points_together() -> None:
    """Ends of distances, which stay in the reduced system, with points that are eliminated and a fixed height."""
    cofactors, _, inverse = systems()
    layout, points = cofactors.assembler.layout, np.array([0, 5, 7, 9, 46])
    assert set(layout.kept_points) & set(points) and set(points) - set(layout.kept_points)
    place = layout.unknown_of_point[points].ravel()
    sigma = sigma_of(inverse)[place]
    assert (
        scaled(point_cofactors(cofactors, points) - inverse[np.ix_(place, place)], sigma, sigma) < TOLERANCE
    )


def test_redundancy_numbers_sum_to_the_redundancy() -> None:
    _, dense, _ = systems()
    rows, unknowns = dense.design.shape
    assert numbers().total == pytest.approx(rows - unknowns, abs=1e-9 * rows)


def test_redundancy_numbers_are_shares() -> None:
    """None below 0 or above 1, and 0 where nothing is observed."""
    cofactors, _, _ = systems()
    found = numbers()
    for values in (found.curve_rows, found.image_points, found.orientation_priors, found.coefficient_rows):
        assert values.min() > -TOLERANCE and values.max() < 1.0 + TOLERANCE
    assert (found.point_priors[cofactors.assembler.point_inverse_sigma == 0.0] == 0.0).all()
    assert (
        found.orientation_priors[~cofactors.solution.linearization.orientation_priors.active] == 0.0
    ).all()
