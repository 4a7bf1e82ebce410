"""Fourier curves, conics and arcs; shape conditions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.curves.conic import CIRCLE_FORMS
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.curves.shape_forms import form_jacobian, form_values, retracted
from splinebba_cli.core.network import Curve, FloatArray

ROWS = np.random.default_rng(8).normal(0.0, 10.0, (7, 3))
CIRCLE = np.array([[5.0, 6.0, 7.0], [3.0, 0.0, 4.0], [0.0, 5.0, 0.0]])


def curve(family: str, rows: FloatArray, **options: object) -> Curve:
    return replace(Curve("c", "tie", family, rows, np.full_like(rows, np.inf)), **options)  # type: ignore[arg-type]


def test_fourier_coefficients_are_those_of_the_discrete_transform() -> None:
    """Samples of the curve transformed back by numpy's FFT."""
    basis = basis_of(curve("fourier", ROWS))
    n = 32
    samples = basis.evaluate(2.0 * np.pi * np.arange(n) / n, ROWS)
    spectrum = np.fft.rfft(samples, axis=0) / n
    np.testing.assert_allclose(spectrum[0].real, ROWS[0], atol=1e-13)
    np.testing.assert_allclose(2.0 * spectrum[1:4].real, ROWS[1::2], atol=1e-13)
    np.testing.assert_allclose(-2.0 * spectrum[1:4].imag, ROWS[2::2], atol=1e-13)
    assert np.abs(spectrum[4:]).max() < 1e-13


def test_segments_are_dense_enough_for_foot_points() -> None:
    for rows, least in ((ROWS[:3], 4), (ROWS[:5], 8), (ROWS, 12)):
        assert basis_of(curve("fourier", rows)).segment_count >= least
    assert basis_of(curve("conic", ROWS[:3])).segment_count == 4
    arc = curve("conic", ROWS[:3], knot_parameters=np.array([0.3, 2.5]))
    assert np.diff(basis_of(arc).break_points).max() <= 0.5 * np.pi


def test_whole_conics_are_closed_and_arcs_are_parts_of_them() -> None:
    whole, arc = (
        basis_of(curve("circle", CIRCLE)),
        basis_of(curve("circle", CIRCLE, knot_parameters=np.array([-1.0, 2.0]))),
    )
    assert whole.closed and not arc.closed
    u = np.linspace(-1.0, 2.0, 20)
    np.testing.assert_allclose(arc.evaluate(u, CIRCLE), whole.evaluate(u, CIRCLE), atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(whole.evaluate(u, CIRCLE) - CIRCLE[0], axis=1), 5.0)
    full_turn = basis_of(curve("conic", CIRCLE, knot_parameters=np.array([0.0, 2.0 * np.pi])))
    assert full_turn.segment_count == 4 and not full_turn.closed


@pytest.mark.parametrize("ends", [[0.0], [1.0, 1.0], [2.0, 1.0], [0.0, 6.4], [0.0, 1.0, 2.0]])
def test_no_arcs(ends: list[float]) -> None:
    with pytest.raises(ValueError, match="arc"):
        basis_of(curve("conic", CIRCLE, knot_parameters=np.array(ends)))


def test_forms_of_a_circle() -> None:
    """(|A|^2 - |B|^2) / 2 and A . B."""
    rows = ROWS[:3]
    expected = [0.5 * (rows[1] @ rows[1] - rows[2] @ rows[2]), rows[1] @ rows[2]]
    np.testing.assert_allclose(form_values(CIRCLE_FORMS, rows), expected)
    assert np.abs(form_values(CIRCLE_FORMS, CIRCLE)).max() == 0.0
    assert form_jacobian(CIRCLE_FORMS, rows)[:, 0].tolist() == [[0.0] * 3] * 2  # the centre is free


@pytest.mark.parametrize("size", [1e-6, 1e-2, 1.0])
def test_retraction_gives_the_nearest_circle(size: float) -> None:
    """Oracle: the orthogonal polar factor, times the mean singular value, is nearest to [A B]."""
    noisy = CIRCLE + size * np.random.default_rng(3).normal(size=(3, 3))
    found = retracted(CIRCLE_FORMS, noisy)
    assert np.abs(form_values(CIRCLE_FORMS, found)).max() < 1e-13
    np.testing.assert_array_equal(found[0], noisy[0])
    u, s, vt = np.linalg.svd(noisy[1:].T, full_matrices=False)
    nearest = (s.mean() * u @ vt).T
    # the shortest step to the linearised forms: nearest to first order, off by the square of the distance
    assert np.abs(found[1:] - nearest).max() < 0.5 * size**2 + 1e-14


def test_retraction_leaves_what_is_a_circle() -> None:
    np.testing.assert_array_equal(retracted(CIRCLE_FORMS, CIRCLE), CIRCLE)
