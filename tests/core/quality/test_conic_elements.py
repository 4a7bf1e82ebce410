"""Elements of conics, their Jacobian by the complex step, and forms."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.conic_elements import conic_elements, conic_form, conic_jacobian
from tests.core.family_features import of_family
from tests.core.free_curves import block_with
from tests.core.observations import complex_step


def random_conic(seed: int) -> FloatArray:
    return np.random.default_rng(seed).normal(0.0, 10.0, (3, 3))


def closed_formula(x: complex_step.Array) -> complex_step.Array:
    """Semi-axes from the eigenvalues of the 2 x 2 matrix of scalar products; eccentricity; the unit normal."""
    _, a, b = x.reshape(3, 3)
    mean, half, mixed = 0.5 * (a @ a + b @ b), 0.5 * (a @ a - b @ b), a @ b
    root = np.sqrt(half**2 + mixed**2)
    first, second = np.sqrt(mean + root), np.sqrt(mean - root)
    normal = np.cross(a, b)
    return np.array(
        [first, second, np.sqrt(1.0 - (second / first) ** 2), *(normal / np.sqrt(normal @ normal))]
    )


@pytest.mark.parametrize("seed", range(20))
def test_jacobian_equals_the_complex_step(seed: int) -> None:
    values = random_conic(seed)
    axes, directions, normal, _ = conic_elements(values)
    exact = complex_step.jacobian(closed_formula, values.ravel())
    found = conic_jacobian(values)
    np.testing.assert_allclose(np.real(closed_formula(values.ravel().astype(complex)))[:2], axes, rtol=1e-12)
    np.testing.assert_allclose(found[:3], exact[:3], rtol=0.0, atol=1e-9 * np.abs(exact[:3]).max())
    turned = np.sign(np.cross(values[1], values[2]) @ normal) * directions @ exact[3:]
    np.testing.assert_allclose(found[3:], turned, rtol=0.0, atol=1e-9 * np.abs(turned).max())


@pytest.mark.parametrize("phase", [0.3, 2.0, -1.2])
def test_elements_do_not_depend_on_the_phase(phase: float) -> None:
    values = random_conic(3)
    c, s = np.cos(phase), np.sin(phase)
    other = np.vstack([values[0], c * values[1] + s * values[2], -s * values[1] + c * values[2]])
    for mine, yours in zip(conic_elements(other), conic_elements(values), strict=True):
        np.testing.assert_allclose(np.abs(mine), np.abs(yours), atol=1e-12)


def test_axes_are_the_extreme_radii() -> None:
    values = random_conic(4)
    axes, directions, normal, eccentricity = conic_elements(values)
    u = np.linspace(0.0, 2.0 * np.pi, 200_001)[:, None]
    radius = np.cos(u) * values[1] + np.sin(u) * values[2]
    length = np.linalg.norm(radius, axis=1)
    np.testing.assert_allclose(axes, [length.max(), length.min()], rtol=1e-9)
    assert abs(radius[np.argmax(length)] @ directions[0]) == pytest.approx(axes[0], rel=1e-8)
    assert np.abs(radius @ normal).max() < 1e-12 and normal[2] > 0.0
    assert eccentricity == pytest.approx(np.sqrt(1.0 - (length.min() / length.max()) ** 2), rel=1e-8)


def test_forms_of_lee() -> None:
    """Table 4.1."""
    forms = {0.0: "circle", 0.3: "ellipse", 0.999: "ellipse", 1.0: "parabola", 1.2: "hyperbola"}
    assert {e: conic_form(e) for e in forms} == forms


def test_eccentricity_of_a_round_conic_has_no_derivative() -> None:
    values = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]])
    found = conic_jacobian(values)
    assert np.isnan(found[2]).all() and np.isfinite(np.delete(found, 2, axis=0)).all()


def test_an_adjusted_circle_is_one() -> None:
    network, truth = block_with(of_family("circle"), of_family("conic"), fixed=True, per_curve=20)
    circle, ellipse = (result.conic for result in adjust(network).curves)
    assert circle is not None and ellipse is not None
    assert (circle.form, circle.eccentricity, circle.eccentricity_sigma) == ("circle", 0.0, 0.0)
    assert circle.semi_axes[0] == pytest.approx(circle.semi_axes[1], rel=1e-12)
    assert circle.semi_axes_sigma[0] == pytest.approx(circle.semi_axes_sigma[1], rel=1e-3)
    assert abs(circle.semi_axes[0] - 60.0) < 5.0 * circle.semi_axes_sigma[0]
    assert ellipse.form == "ellipse"
    axes, _, normal, eccentricity = conic_elements(truth.curves[1])
    assert (np.abs(ellipse.semi_axes - axes) < 5.0 * ellipse.semi_axes_sigma).all()
    assert abs(ellipse.eccentricity - eccentricity) < 5.0 * ellipse.eccentricity_sigma
    assert np.linalg.norm(np.cross(normal, ellipse.normal)) < 5.0 * ellipse.normal_sigma_rad
    assert (np.abs(ellipse.centre - truth.curves[1][0]) < 5.0 * ellipse.centre_sigma).all()
