"""Exponents of growth."""

from __future__ import annotations

import pytest

from benchmarks.power_law import exponent


@pytest.mark.parametrize("power", [0.0, 1.0, 1.2, 2.0])
def test_an_exact_power_is_found(power: float) -> None:
    assert exponent([(n, 3.0 * n**power) for n in (100.0, 1000.0, 50000.0)]) == pytest.approx(
        power, abs=1e-12
    )


def test_least_squares_of_the_logarithms() -> None:
    # residuals +e, -2e, +e of equally spaced logarithms leave the slope as it is
    assert exponent([(1.0, 1.1), (10.0, 10.0 / 1.21), (100.0, 110.0)]) == pytest.approx(1.0)


def test_no_exponent_of_one_size_or_of_zero() -> None:
    assert exponent([(10.0, 1.0), (10.0, 2.0)]) is None
    assert exponent([(10.0, 0.0), (20.0, 2.0)]) is None
