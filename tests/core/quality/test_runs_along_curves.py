"""Neighbours along curves: moments of the statistic against the dense R and by sampling."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.quality import runs_along_curves as module
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from tests.core.quality.test_residual_projector import systems


def rows_of(curve: int) -> np.ndarray:
    projector, _, _ = systems()
    rows = PhotoRows.of(projector)
    own = np.flatnonzero(rows.across & (rows.curve == curve))
    return own[np.lexsort((projector.solution.state.location[own], rows.image[own]))]


def test_cofactors_of_the_residuals_of_one_curve() -> None:
    projector, _, r = systems()
    own = rows_of(3)
    unknowns = np.unique(projector.design.reduced[own].indices)
    found = module._residual_cofactors(projector, own, unknowns)
    np.testing.assert_allclose(found, r[np.ix_(own, own)], rtol=0.0, atol=1e-8)


def test_pairs_are_neighbours_in_one_image() -> None:
    assert module.neighbours(np.array([0, 0, 0, 1, 2, 2])).tolist() == [0, 1, 4]


def test_moments_by_sampling() -> None:
    """r = R e: mean 0 and variance 1 of z; 4000 samples, five standard deviations of either figure (1 - 1e-6)."""
    _, _, r = systems()
    own = rows_of(3)
    rows = PhotoRows.of(systems()[0])
    first = module.neighbours(rows.image[own])
    cofactors = r[np.ix_(own, own)]
    rho, square, trace = module._moments(first, cofactors)
    assert rho < 0.0  # the adjustment makes neighbours differ
    samples = 4000
    v = (r @ np.random.default_rng(4).standard_normal((len(r), samples)))[own]
    t = np.sum(v[first] * v[first + 1], axis=0) - rho * np.sum(v**2, axis=0)
    z = t / np.sqrt(2.0 * square)
    assert abs(z.mean()) < 5.0 / np.sqrt(samples)
    assert z.var() == pytest.approx(
        1.0, abs=5.0 * np.sqrt(3.0 / samples)
    )  # kurtosis of a quadratic form below 4
    assert np.sum(v**2, axis=0).mean() == pytest.approx(trace, rel=5.0 * np.sqrt(2.0 / trace / samples))


def test_small_networks_use_the_exact_moments() -> None:
    """The statistic of a curve is that of its dense R, with the correlation that the adjustment itself makes."""
    projector, _, r = systems()
    cofactors = Cofactors(projector.assembler, projector.solution)
    redundancy = redundancy_numbers(cofactors, linked_cofactors(cofactors)).curve_rows
    rows = PhotoRows.of(projector)
    name = projector.assembler.prepared.network.curves[3].id
    found = {each.subject: each for each in module.runs_along_curves(projector, rows, redundancy)}
    own = rows_of(3)
    first, block, v = module.neighbours(rows.image[own]), r[np.ix_(own, own)], rows.residual[own]
    rho, square, trace = module._moments(first, block)
    t = float(v[first] @ v[first + 1]) - rho * float(v @ v)
    expected = t / (float(v @ v) / trace * np.sqrt(2.0 * square))
    assert rho < -1e-3
    assert found[f"spline `{name}`"].statistic == pytest.approx(expected, abs=1e-6)
