"""The ellipse nearest to a closed curve."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.curves.basis import harmonic_row
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.quality.conic_elements import conic_elements
from splinebba_cli.core.quality.nearest_ellipse import nearest_ellipse
from tests.core.family_features import ELLIPSE, circle_rows, of_family


@pytest.mark.parametrize("name", ["circle", "conic"])
def test_of_an_ellipse_it_is_itself(name: str) -> None:
    """u of the curve has nothing to do with arc length: the iterations find the foot points."""
    found = nearest_ellipse(*of_family(name).shape())
    axes, _, normal, _ = conic_elements(of_family(name).values)
    np.testing.assert_allclose(found.centre, ELLIPSE[0], atol=1e-6)
    np.testing.assert_allclose(found.semi_axes, axes, atol=1e-5)
    np.testing.assert_allclose(found.normal, normal, atol=1e-7)
    assert found.rms_m < 1e-5 and found.largest_m < 1e-5


@pytest.mark.parametrize("knots", [6, 8, 12])
def test_model_error_of_a_natural_spline(knots: int) -> None:
    """The spline through equally spaced knots of a circle is round; its error falls with the spacing to the fourth.

    Between knots h apart a periodic cubic spline of exp(iu) misses it by h^4 / 384 and a little more.
    """
    u = 2.0 * np.pi * np.arange(knots) / knots
    basis = natural_cubic_basis(np.arange(knots + 1.0), closed=True)
    coefficients = basis.coefficients_from_values(harmonic_row(u, 0, 3) @ circle_rows(60.0))
    found = nearest_ellipse(basis, coefficients)
    assert found.semi_axes[0] == pytest.approx(found.semi_axes[1], rel=1e-6)
    bound = 60.0 * (2.0 * np.pi / knots) ** 4 / 384.0
    assert 0.3 * bound < found.largest_m < 1.3 * bound


def test_a_curve_that_is_no_ellipse_is_not_near_one() -> None:
    found = nearest_ellipse(*of_family("fourier").shape())
    assert 5.0 < found.rms_m < found.largest_m
