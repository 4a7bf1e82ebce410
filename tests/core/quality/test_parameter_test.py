"""Tests of parameters on linear models with known distributions.

Monte Carlo: N = 4000 draws; a rate of 5 % lies in the binomial interval of 99 %, a mean of chi-square statistics of f
degrees of freedom within 2.58 sqrt(2 f / N).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.quality.parameter_test import wald_tests
from splinebba_cli.core.quality.similarity_fit import fit_similarity
from splinebba_cli.core.quality.variance_comparison import (
    SumOfSquares,
    additional_parameters,
    equal_variances,
)

N, ALPHA, ROWS, PART = 4000, 0.05, 24, 14
RNG = np.random.default_rng(11)
A = RNG.normal(size=(ROWS, 6))
E = RNG.normal(size=(N, ROWS))


def inside(rate: float) -> bool:
    lower, upper = stats.binom.ppf([0.005, 0.995], N, ALPHA) / N
    return bool(lower <= rate <= upper)


def solved(design: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Estimates (N, k), cofactors, v'Pv (N,)."""
    q = np.linalg.inv(design.T @ design)
    x = y @ design @ q
    return x, q, np.sum((y - x @ design.T) ** 2, axis=1)


def test_part_and_whole() -> None:
    """Hausman: cov(part, whole) = Q_whole; with sigma of the part the test is exactly F, also for few observations."""
    part, q_part, vtpv = solved(A[:PART], E[:, :PART])
    whole, q_whole, _ = solved(A, E)
    d = part - whole
    dispersion = q_part - q_whole
    empirical = d.T @ d / N
    ratio = np.diag(empirical) / np.diag(dispersion)
    assert np.abs(ratio - 1.0).max() < 3.3 * np.sqrt(2.0 / N)  # six variances, 99 % together
    known = wald_tests(d, np.tile(dispersion, (N, 1, 1)), np.tile(q_part, (N, 1, 1)), None)
    assert (known.dimensions == 6).all()
    assert abs(known.statistic.mean() - 6.0) < 2.58 * np.sqrt(12.0 / N)
    assert inside(float(known.significant(ALPHA).mean()))
    s2 = vtpv / (PART - 6)
    scaled = s2[:, None, None]
    estimated = wald_tests(d, dispersion * scaled, q_part * scaled, PART - 6.0)
    assert inside(float(estimated.significant(ALPHA).mean()))


def test_what_the_whole_does_not_add_to_is_not_tested() -> None:
    """The added observations see three of six parameters; the part does not correlate them with the others."""
    design = np.kron(np.eye(2), A[:10, :3])
    more = np.vstack([design, np.hstack([A[:5, 3:], np.zeros((5, 3))])])
    q_part, q_whole = np.linalg.inv(design.T @ design), np.linalg.inv(more.T @ more)
    tests = wald_tests(np.ones((1, 6)), (q_part - q_whole)[None], q_part[None], None)
    assert tests.dimensions.tolist() == [3]


def test_held_parameters_are_left_out() -> None:
    dispersion = np.diag([4.0, 0.0, 9.0])[None]
    tests = wald_tests(np.array([[4.0, 7.0, 3.0]]), dispersion, dispersion, None)
    assert tests.dimensions.tolist() == [2]
    assert tests.statistic[0] == pytest.approx(5.0)
    assert tests.probability[0] == pytest.approx(stats.chi2.sf(5.0, 2))
    nothing = wald_tests(np.zeros((1, 3)), np.zeros((1, 3, 3)), np.zeros((1, 3, 3)), None)
    assert nothing.dimensions.tolist() == [0] and np.isnan(nothing.probability[0])
    assert not nothing.significant(0.05).any()


def test_nearly_dependent_parameters() -> None:
    """r = 1 - 1e-9: (x, y) = (1, 1) is likely, (1, -1) is not."""
    dispersion = np.array([[1.0, 1.0 - 1e-9], [1.0 - 1e-9, 1.0]])
    tests = wald_tests(
        np.array([[1.0, 1.0], [1.0, -1.0]]),
        np.tile(dispersion, (2, 1, 1)),
        np.tile(dispersion, (2, 1, 1)),
        None,
    )
    assert tests.statistic[0] == pytest.approx(1.0, rel=1e-6)
    assert tests.statistic[1] == pytest.approx(2e9, rel=1e-3)


def test_additional_parameters() -> None:
    _, _, small = solved(A[:, :4], E)
    _, _, large = solved(A, E)
    for known in (False, True):
        rate = np.mean(
            [
                additional_parameters(
                    SumOfSquares(s, ROWS - 4.0), SumOfSquares(g, ROWS - 6.0), ALPHA, sigma0_known=known
                ).significant  # type: ignore[union-attr]
                for s, g in zip(small, large, strict=True)
            ]
        )
        assert inside(float(rate)), known
    assert additional_parameters(SumOfSquares(9.0, 5), SumOfSquares(8.0, 5), ALPHA, sigma0_known=True) is None


def test_variances_of_independent_adjustments() -> None:
    _, _, a = solved(A[:PART], E[:, :PART])
    _, _, b = solved(A[PART:, :3], E[:, PART:])
    pairs = [
        (SumOfSquares(x, PART - 6.0), SumOfSquares(y, ROWS - PART - 3.0)) for x, y in zip(a, b, strict=True)
    ]
    tests = [equal_variances(x, y, ALPHA) for x, y in pairs]
    assert inside(float(np.mean([test.significant for test in tests if test is not None])))
    for test in tests[:50]:
        assert test is not None and test.significant == (test.probability < ALPHA)
    assert equal_variances(SumOfSquares(1.0, 0), SumOfSquares(1.0, 4), ALPHA) is None


def test_similarity_comes_back() -> None:
    rotation = rotation_from_vector(np.array([[0.3, -0.2, 2.5]]))[0]
    x = RNG.normal(size=(7, 3)) * 500.0 + [5e5, 4e6, 300.0]
    y = 1.2 * (x - x.mean(axis=0)) @ rotation.T + [10.0, 20.0, 30.0]
    found = fit_similarity(x, y)
    assert found is not None
    assert found.scale == pytest.approx(1.2, rel=1e-12)
    assert found.rotation == pytest.approx(rotation, abs=1e-12)
    assert found.angles == pytest.approx([0.3, -0.2, 2.5], abs=1e-9)
    assert found.apply(x) == pytest.approx(y, abs=1e-6)
    assert found.rms < 1e-6
    mirrored = fit_similarity(x, x * [1.0, 1.0, -1.0])
    assert mirrored is not None and np.linalg.det(mirrored.rotation) == pytest.approx(1.0)
    assert fit_similarity(x[:2], y[:2]) is None
    assert fit_similarity(np.outer(np.arange(5.0), [1, 2, 3]), np.outer(np.arange(5.0), [1, 2, 3])) is None
