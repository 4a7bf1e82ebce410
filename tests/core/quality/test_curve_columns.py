"""Results of curves in columns: one curve at a time is what was asked for."""

from __future__ import annotations

from dataclasses import astuple, fields
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult
from tests.core.small_networks import mixed_network


@cache
def result() -> AdjustmentResult:
    return adjust(mixed_network()[0])


def test_every_curve_has_its_own_rows() -> None:
    """The knots are where its basis puts them, with the values that it has."""
    found, network = result(), result().network
    assert len(found.curves) == len(network.curves)
    for curve, given in zip(found.curves, network.curves, strict=True):
        basis = basis_of(given)
        assert len(curve.values) == len(given.values) == len(curve.reference) == len(curve.values_dispersion)
        np.testing.assert_allclose(
            curve.knot_parameters, basis.break_points[: len(curve.knots)], rtol=1e-14, atol=1e-14
        )
        own = basis.coefficients_from_values(curve.values)
        at_samples = basis.evaluate(curve.sample_u, own)
        np.testing.assert_allclose(curve.sample_xyz, at_samples, rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(
            curve.knots, basis.evaluate(curve.knot_parameters, own), rtol=0.0, atol=1e-8
        )


def test_counts_and_residuals_of_one_curve() -> None:
    found, seen = result(), result().network.curve_observations
    for k, curve in enumerate(found.curves):
        rows = np.flatnonzero(seen.curve == k)
        assert curve.n_observations == len(rows)
        assert curve.n_images == len(np.unique(seen.image[rows]))
        expected = np.sqrt(np.mean(found.curve_residuals.across[rows] ** 2))
        assert curve.rms_across_mm == pytest.approx(expected, rel=1e-12)
        assert curve.sigma_across_max == curve.sample_across[:, 0].max()
        assert curve.sigma_across_mean == pytest.approx(np.sqrt(np.mean(curve.sample_across**2)), rel=1e-12)


def test_as_a_sequence() -> None:
    curves = result().curves
    assert isinstance(curves, CurveColumns)
    last = len(curves) - 1
    np.testing.assert_array_equal(curves[-1].values, curves[last].values)
    assert [len(each.knots) for each in curves[1:]] == [len(curves[k].knots) for k in range(1, len(curves))]
    with pytest.raises(IndexError):
        curves[len(curves)]


def test_columns_of_results_one_by_one() -> None:
    columns, alone = CurveColumns.of(result().curves), CurveColumns.of(tuple(result().curves))
    for field in fields(CurveColumns):
        found, expected = getattr(alone, field.name), getattr(columns, field.name)
        if isinstance(expected, np.ndarray) and not field.name.startswith("segment"):
            np.testing.assert_array_equal(found, expected, field.name)
    assert (columns.conics.keys(), columns.ellipses.keys()) == (alone.conics.keys(), alone.ellipses.keys())
    np.testing.assert_array_equal(alone.segment_counts, columns.segment_counts)
    for found, expected in zip(astuple(alone.power_segments), astuple(columns.power_segments), strict=True):
        np.testing.assert_array_equal(found, expected)
    assert CurveColumns.of(()).sample_across.shape == (0, 2)
