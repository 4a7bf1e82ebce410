"""The Monte Carlo loop accepts a right dispersion and rejects wrong ones; intervals against known values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.errors import NotConvergedError
from splinebba_cli.simulation.campaign_statistics import all_elements, kind_statistics
from splinebba_cli.simulation.intervals import estimated_share, within_confidence
from splinebba_cli.simulation.monte_carlo import (
    MonteCarloResult,
    binomial_interval,
    mean_square_interval,
    run_monte_carlo,
)
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth

FREEDOM = 200
BLOCK, TRUE_BLOCK = simulate_block("strip")
NETWORK = replace(BLOCK, curves=(), points=replace(BLOCK.points, ids=(), role=()))  # its orientations alone
TRUTH = replace(TRUE_BLOCK, curves=(), points=np.zeros((0, 3)))


def correlated(m: int) -> FloatArray:
    """A dispersion of m x 6 elements, correlations of 0.99, units as far apart as angles and metres."""
    root = np.eye(6)
    root[3, 1], root[4, 0] = 7.0, -7.0
    scale = np.array([1e-4, 1e-4, 1e-5, 0.05, 0.05, 0.02])
    return np.tile(scale[:, None] * (root @ root.T) * scale, (m, 1, 1))


@dataclass(frozen=True)
class FakeAdjustment:
    """Draws errors from the true dispersion and reports `factor` times their standard deviations."""

    factor: float = 1.0
    fail_seed: int = -1

    def make(self, seed: int) -> tuple[Network, Truth]:
        images = replace(NETWORK.images, ids=(str(seed),))  # carries the seed to the adjustment
        return replace(NETWORK, images=images), TRUTH

    def adjust(self, network: Network) -> Any:
        seed = int(network.images.ids[0])
        if seed == self.fail_seed:
            raise NotConvergedError
        rng = np.random.default_rng(seed)
        dispersion = correlated(len(TRUTH.eop))
        error = np.einsum("mij,mj->mi", np.linalg.cholesky(dispersion), rng.standard_normal(TRUTH.eop.shape))
        eop = TRUTH.eop + error
        eop[:, 3:] += network.origin
        eop[0, 2] += 2.0 * np.pi  # a full turn is no error
        sigma0 = np.sqrt(rng.chisquare(FREEDOM) / FREEDOM)
        estimated = np.ones(eop.shape, dtype=bool)
        reported = dispersion * (self.factor * sigma0) ** 2
        passed = bool(abs(sigma0**2 - 1.0) < 1.96 * np.sqrt(2.0 / FREEDOM))
        return SimpleNamespace(
            network=network,
            images=SimpleNamespace(eop=eop, dispersion=reported, estimated=estimated),
            points=SimpleNamespace(xyz=np.zeros((0, 3)), dispersion=np.zeros((0, 3, 3))),
            curves=(),
            iterations=(),
            statistics=SimpleNamespace(
                sigma0=sigma0,
                sigma0_prior=1.0,
                redundancy=FREEDOM,
                global_test=SimpleNamespace(passed=passed, alpha=0.05),
            ),
        )


def run(fake: FakeAdjustment, runs: int = 200) -> MonteCarloResult:
    return run_monte_carlo(fake.make, fake.adjust, runs, seed=100)


def test_a_right_dispersion_is_accepted() -> None:
    result = run(FakeAdjustment())
    assert result.failures == 0 and result.errors.shape == (200, 5, 6)
    assert result.mean_square.inside
    assert result.acceptance.inside
    assert sum(figure.inside for figure in result.image_mean_squares) >= 4
    lower, upper = result.sigma_ratio_interval()
    assert ((result.sigma_ratio > lower) & (result.sigma_ratio < upper)).all()


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_a_wrong_dispersion_is_rejected(factor: float) -> None:
    result = run(FakeAdjustment(factor))
    assert not result.mean_square.inside
    assert result.mean_square.value == pytest.approx(factor**-2, rel=0.1)
    lower, upper = result.sigma_ratio_interval()
    assert not ((result.sigma_ratio > lower) & (result.sigma_ratio < upper)).all()


def test_runs_without_solution_are_counted() -> None:
    result = run(FakeAdjustment(fail_seed=103), runs=8)
    assert (result.runs, result.failures, len(result.errors)) == (8, 1, 7)
    with pytest.raises(ValueError, match="none of 1 runs"):
        run(FakeAdjustment(fail_seed=100), runs=1)


@pytest.mark.parametrize(("factor", "right"), [(1.0, True), (0.8, False), (1.25, False)])
def test_coverage_is_that_of_the_confidence_only_where_the_dispersion_is_right(
    factor: float, right: bool
) -> None:
    """5 images, 6 elements of 200 runs; 0.8 and 1.25 times the σ cover 88 % and 98.6 %."""
    result = run(FakeAdjustment(factor))
    elements = [each for image in all_elements(result, "eop", 0.95) for each in image if each is not None]
    kind = kind_statistics(elements, result, 0.95)
    assert kind is not None and kind.elements == 30
    assert kind.coverage.inside is right, kind.coverage


def test_confidence_regions_of_scaled_dispersions_follow_f() -> None:
    """5 %, 95 % table values of F(2, 10) = 4.103 and chi-square(2) = 5.991."""
    squares = np.array([2.0 * 4.10 * 1.5**2, 2.0 * 4.11 * 1.5**2])
    scaled, many = np.array([1.5, 1.5]), np.array([10.0, 10.0])
    assert within_confidence(squares, 2.0, scaled, many, 0.95).tolist() == [True, False]
    unscaled = np.array([np.nan, np.nan])
    assert within_confidence(np.array([5.99, 6.0]), 2.0, unscaled, many, 0.95).tolist() == [True, False]


def test_interval_of_an_estimated_share() -> None:
    """Clopper-Pearson: no success in n runs gives 1 - (0.005)^(1/n); the interval of k holds k/n."""
    assert estimated_share(0, 20).upper == pytest.approx(1.0 - 0.005 ** (1 / 20))
    assert estimated_share(20, 20).lower == pytest.approx(0.005 ** (1 / 20))
    half = estimated_share(10, 20)
    assert half.lower < 0.5 < half.upper and half.lower + half.upper == pytest.approx(1.0)


def test_chi_square_interval() -> None:
    """Table values: 0.5 % and 99.5 % quantiles of chi-square with 10 degrees of freedom."""
    lower, upper = mean_square_interval(10)
    assert 10 * lower == pytest.approx(2.15586, abs=1e-5)
    assert 10 * upper == pytest.approx(25.18818, abs=1e-5)


def test_binomial_interval_holds_the_probability_and_no_more_than_needed() -> None:
    lower, upper = binomial_interval(200, 0.95)
    draws = np.random.default_rng(1).binomial(200, 0.95, 200_000) / 200
    assert np.mean((draws >= lower) & (draws <= upper)) >= 0.99
    assert np.mean(draws < lower + 1 / 200) > 0.005  # one step tighter would lose more than 0.5 %
    assert np.mean(draws > upper - 1 / 200) > 0.005
