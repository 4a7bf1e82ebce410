"""Variances of groups against the dense R: redundancy, the matrix M and Helmert's estimate."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality import group_variances as module
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.group_sums import GroupSum, group_sums
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.observation_groups import observation_groups
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from tests.core.quality.test_residual_projector import systems


@cache
def sums() -> list[GroupSum]:
    projector, _, _ = systems()
    cofactors = Cofactors(projector.assembler, projector.solution)
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    return group_sums(projector, numbers, observation_groups(projector.assembler.prepared.network))


def dense_blocks() -> FloatArray:
    r = systems()[2]
    return np.array([[np.sum(r[np.ix_(g.rows, h.rows)] ** 2) for h in sums()] for g in sums()])


def test_groups_and_their_rows() -> None:
    """Every stochastic equation is in one group; conditions, held values and held angles are in none."""
    assert [each.group.name for each in sums()] == [
        "points", "splines", "distances", "control points", "control splines", "prior angles", "prior positions",
    ]  # fmt: skip
    projector, _, r = systems()
    rows = np.concatenate([each.rows for each in sums()])
    assert len(np.unique(rows)) == len(rows)
    for each in sums():
        assert each.redundancy == pytest.approx(np.trace(r[np.ix_(each.rows, each.rows)]), abs=1e-7)
        assert each.squares == pytest.approx(np.sum(projector.design.residual[each.rows] ** 2))
    left_out = np.setdiff1d(np.arange(projector.design.ranges.count), rows)
    assert (left_out >= projector.design.ranges.coefficients).all()


def test_small_groups_exactly_and_large_ones_by_sampling() -> None:
    """Of a sampled block the standard deviation is at most sqrt(2 / rows drawn), 1.6 %: 5 % is three of them."""
    found = module.squared_blocks(systems()[0], sums())
    small = np.array([len(each.rows) <= module.EXACT for each in sums()])
    exact = np.ix_(small, small)
    np.testing.assert_allclose(found[exact], dense_blocks()[exact], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(np.diag(found), np.diag(dense_blocks()), rtol=0.05)
    np.testing.assert_allclose(found.sum(axis=1), [each.redundancy for each in sums()], rtol=0.05)


def test_the_expected_squares_of_wrong_sigma_give_the_variances_back() -> None:
    """c = M s whatever s is: the estimate is unbiased although the weights are wrong."""
    true = np.array([0.25, 9.0, 1.5, 1.0, 2.0, 1.0, 0.5])
    projector, _, _ = systems()
    matrix = module.squared_blocks(projector, sums())
    rest = np.array([each.redundancy for each in sums()]) - matrix.sum(axis=1)
    expected = [
        GroupSum(each.group, each.equations, float(c), each.redundancy, each.rows, each.complete)
        for each, c in zip(sums(), matrix @ true + rest, strict=True)
    ]
    np.testing.assert_allclose(module.group_variances(projector, expected).variance, true, rtol=1e-8)


def test_covariances_of_the_squares_with_other_variances() -> None:
    """K = |(R S R)_gh|^2 against the dense R; sampled blocks to 5 %, as above."""
    true = np.array([0.25, 9.0, 1.5, 1.0, 2.0, 1.0, 0.5])
    projector, _, r = systems()
    weight = np.ones(len(r))
    for each, variance in zip(sums(), true, strict=True):
        weight[each.rows] = variance
    k = r @ (weight[:, None] * r)
    found = module.squared_blocks(projector, sums(), true)
    for g, each in enumerate(sums()):
        assert found[g, g] == pytest.approx(np.sum(k[np.ix_(each.rows, each.rows)] ** 2), rel=0.05)


def test_equivalent_degrees_of_freedom_are_at_most_the_redundancy() -> None:
    found = module.group_variances(systems()[0], sums())
    assert (found.freedom <= np.array([each.redundancy for each in sums()]) * (1.0 + 1e-9)).all()
    assert (found.freedom > 0.0).all()


def test_residuals_of_zero_have_a_variance_of_zero() -> None:
    """Noise-free measurements: no division by zero, and the degrees of freedom of right weights."""
    nothing = [
        GroupSum(each.group, each.equations, 0.0, each.redundancy, each.rows, each.complete)
        for each in sums()
    ]
    found = module.group_variances(systems()[0], nothing)
    assert (np.nan_to_num(found.variance) <= 0.3).all() and np.isfinite(found.freedom).all()
