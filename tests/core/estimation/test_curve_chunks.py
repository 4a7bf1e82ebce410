"""Equations of curve points in chunks against those of all points at once."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.estimation import curve_chunks
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.curve_chunks import CurveEquations, along_points, equation_rows
from splinebba_cli.core.quality import curve_figures
from splinebba_cli.core.quality.cofactors import Cofactors
from tests.core.small_networks import mixed_network, solved


@cache
def solution() -> ConditionedSolution:
    found = solved(mixed_network()[0])
    assert len(along_points(found.assembler, found.solution.linearization)) > 1
    return found


def test_chunks_are_the_equations_of_all_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sums of three products in another grouping: equal to rounding."""
    at = solution().solution.linearization
    monkeypatch.setattr(curve_chunks, "CHUNK", 37)
    found = CurveEquations.at(solution().assembler, at)
    np.testing.assert_array_equal(found.point, at.curve.point)
    np.testing.assert_array_equal(found.segment, at.curve.segment)
    np.testing.assert_allclose(found.normal, at.curve.normal, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(found.residual, at.curve.residual, rtol=0.0, atol=1e-9)
    scale = np.abs(at.curve_jacobian).max()
    np.testing.assert_allclose(found.jacobian, at.curve_jacobian[:, :-1], rtol=0.0, atol=1e-13 * scale)


def test_single_equations_in_any_order() -> None:
    at = solution().solution.linearization
    count = len(at.curve.point)
    numbers = np.array([count - 1, 5, 2, count - 2, int(at.curve.point[-1])])  # one point across and along
    rows, jacobian = equation_rows(solution().assembler, at, numbers)
    np.testing.assert_array_equal(rows.point, at.curve.point[numbers])
    np.testing.assert_array_equal(rows.image, at.curve.image[numbers])
    scale = np.abs(at.curve_jacobian).max()
    np.testing.assert_allclose(jacobian, at.curve_jacobian[numbers, :-1], rtol=0.0, atol=1e-13 * scale)
    for name in ("weights", "direction", "orientation"):
        expected = getattr(at.curve, name)[numbers]
        atol = 1e-13 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(rows, name), expected, rtol=0.0, atol=atol)


def test_figures_do_not_depend_on_the_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Cofactors(solution().assembler, solution().solution).curve
    monkeypatch.setattr(curve_figures, "CHUNK", 29)
    other = Cofactors(solution().assembler, solution().solution).curve
    for name in ("leverage", "orientation_share", "location"):
        expected = getattr(found, name)
        atol = 1e-12 * max(np.abs(expected).max(), 1.0)
        np.testing.assert_allclose(getattr(other, name), expected, rtol=1e-12, atol=atol)
