"""Tests of a common bias against least squares with the bias as further unknowns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.stats import ncx2

from splinebba_cli.core.quality.bias_tests import TestFamily as Family
from splinebba_cli.core.quality.bias_tests import _tested, bias_tests, noncentrality_of
from tests.core.quality.test_residual_projector import last_step, systems


def family(statistic: str = "w", tests: int = 1) -> Family:
    projector, dense, _ = systems()
    v = projector.design.residual
    rows, unknowns = dense.design.shape
    return Family(statistic, 0.05, 0.8, rows - unknowns, float(v @ v), tests)  # type: ignore[arg-type]


def with_bias_as_unknowns(block: sparse.csc_array) -> tuple[np.ndarray, np.ndarray, float]:
    """Bias, its cofactors and the decrease of v'v, by dense least squares over all unknowns and the bias."""
    _, dense, r = systems()
    c = block.toarray()
    reduced = r @ c  # Frisch-Waugh: the bias from what the other unknowns leave of it
    estimate, *_ = np.linalg.lstsq(reduced, -dense.residual, rcond=None)
    left = dense.residual + reduced @ estimate
    return estimate, np.linalg.inv(c.T @ r @ c), float(dense.residual @ dense.residual - left @ left)


def directions(columns: int, seed: int = 3) -> sparse.csc_array:
    rows = len(systems()[1].residual)
    return sparse.random_array((rows, columns), density=0.1, rng=np.random.default_rng(seed)).tocsc()


def test_estimate_and_statistic_are_those_of_further_unknowns() -> None:
    block = directions(3)
    (test,) = bias_tests(systems()[0], [block], family())
    estimate, cofactors, decrease = with_bias_as_unknowns(block)
    assert test.freedom == 3
    # the solution is short of the minimum by its last step s: |(C'R C)^-1/2 C'A d| <= s / sqrt(shown)
    short = last_step() / np.sqrt(np.linalg.eigvalsh(block.T.toarray() @ systems()[2] @ block.toarray())[0])
    assert np.linalg.norm(test.estimate - estimate) <= short
    np.testing.assert_allclose(test.sigma, np.sqrt(np.diag(cofactors)), rtol=1e-7)
    assert test.statistic == pytest.approx(decrease, abs=3.0 * np.sqrt(decrease) * last_step())


def test_directions_that_the_unknowns_take_up_are_no_test() -> None:
    """A column of the design matrix itself has no residual; beside another direction it takes one degree."""
    _, dense, _ = systems()
    column = sparse.csc_array(dense.design[:, [0]])
    tests = bias_tests(
        systems()[0], [column, sparse.csc_array(sparse.hstack([column, directions(1)]))], family()
    )
    assert [test.freedom for test in tests] == [0, 1]
    assert np.isnan(tests[0].estimate).all() and np.isinf(tests[0].minimal_detectable)


def test_with_an_estimated_sigma0_the_statistic_has_no_scale() -> None:
    """T_F of residuals and sigma that are all too large by the same factor is the same."""
    own = family("tau")
    t = 12.0
    other = Family("tau", 0.05, 0.8, own.redundancy, 9.0 * own.vtpv, 1)
    assert other.statistic_of(9.0 * t, 2) == pytest.approx(own.statistic_of(t, 2))
    assert own.critical(2) > family("w").critical(2)


@pytest.mark.parametrize(("freedom", "power"), [(1, 0.8), (3, 0.8), (3, 0.5)])
def test_noncentrality_has_the_power(freedom: int, power: float) -> None:
    value = noncentrality_of(0.001, power, freedom)
    from scipy.stats import chi2

    assert ncx2.sf(chi2.isf(0.001, freedom), freedom, value) == pytest.approx(power, abs=1e-8)


def test_noncentrality_of_baarda() -> None:
    assert noncentrality_of(0.001, 0.8, 1) == pytest.approx(4.132**2, abs=0.01)


@pytest.mark.parametrize("columns", [1, 3])
def test_without_a_bias_the_statistic_is_chi_square(columns: int) -> None:
    """v = -R e: mean q and variance 2 q in 2000 samples, five standard deviations of either (1 - 1e-6)."""
    _, _, r = systems()
    c = directions(columns).toarray()
    gram, samples = c.T @ r @ c, 2000
    moments = c.T @ (r @ np.random.default_rng(5).standard_normal((len(r), samples)))
    tests = [_tested(moment, c.T @ c, gram, family()) for moment in moments.T]
    t = np.array([test.statistic for test in tests])
    assert abs(t.mean() - columns) < 5.0 * np.sqrt(2.0 * columns / samples)
    assert abs(t.var() - 2.0 * columns) < 5.0 * np.sqrt((48.0 * columns + 8.0 * columns**2) / samples)
    normalized = np.array([test.estimate / test.sigma for test in tests])
    assert abs(np.mean(normalized**2) - 1.0) < 5.0 * np.sqrt(2.0 / samples)
