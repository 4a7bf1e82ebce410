"""One circle in four images, 5 µm, as circle, conic, closed natural spline and Fourier curve: the same shape.

Orientations are known, every curve has measurements of its own: distances across between two adjusted curves follow
the sum of their dispersions.  A natural spline of eight knots misses a circle of radius 5 m by up to 3.4 mm (rms 2 to
3 mm) where its standard deviation across is 10 mm; this is taken from the noise-free adjustment and added below.

d'C^+d summed over the samples of a curve is a mean over correlated chi-squares with 2 degrees of freedom each; they
come from at least 5 independent unknowns (radius, height, plane), so that their mean square lies below that of
chi-square with 5 degrees of freedom at 1 - 1e-5, 6.1, with more than that probability.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from scipy.special import chdtri

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Settings
from splinebba_cli.core.quality.curve_comparison import AdjustedCurve, compare_curves
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.assembly import assemble
from splinebba_cli.simulation.block_geometry import four_images
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.six_image_block import SCENES, simulate_block

RADIUS = 5.0
NAMES = ("as-circle", "as-spline", "as-fourier", "as-conic")
FIVE = float(chdtri(5, 1e-5)) / 5


@cache
def adjusted(noise_um: float, seed: int = 1, origin: float = 0.0) -> AdjustmentResult:
    """The scene of the sample project with known orientations, and the circle once more as a conic."""
    features = SCENES["circle-three-ways"]().features
    circle = features[0]
    features = (*features, replace(circle, id="as-conic", family="conic"))
    noise = Noise(1e-3 * noise_um, 0.0, 0.0, 0.2)
    network, truth = assemble(four_images(), features, PointFeatures(), 40, None, noise, seed)
    images = replace(network.images, prior=truth.eop.copy(), prior_sigma=np.zeros_like(truth.eop))
    settings = Settings(gauge_conditions="all", scale_dispersion=False)
    place = np.array([origin, 0.1 * origin, 0.0])
    return adjust(replace(network, images=images, settings=settings, origin=place))


def curve(result: AdjustmentResult, name: str) -> AdjustedCurve:
    k = [c.id for c in result.network.curves].index(name)
    return AdjustedCurve(result.network.curves[k], result.curves[k])


def truth() -> Feature:
    return SCENES["circle-three-ways"]().features[0]


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("first", "second"), list(combinations(NAMES, 2)))
def test_all_are_the_same_within_their_sigma(first: str, second: str, seed: int) -> None:
    result = adjusted(5.0, seed)
    found = compare_curves(curve(result, first), curve(result, second))
    assert len(found.u) == len(curve(result, first).result.sample_u)
    assert np.mean(found.normalized**2) < FIVE
    assert 0.3 * found.sigma_rms < found.rms < np.sqrt(FIVE) * found.sigma_rms
    assert 0.006 < found.sigma_rms < 0.025


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", NAMES)
def test_centre_radius_and_plane_are_recovered(name: str, seed: int) -> None:
    """Each within 4.5 times what the circle's elements say, enlarged by the freedom of the family."""
    result = adjusted(5.0, seed)
    elements, ellipse = curve(result, "as-circle").result.conic, curve(result, name).result.ellipse
    assert elements is not None and ellipse is not None
    freedom = (
        curve(result, name).result.sigma_across_mean / curve(result, "as-circle").result.sigma_across_mean
    )
    limit = 4.5 * max(freedom, 1.0)
    values = truth().values
    normal = np.cross(values[1], values[2]) / RADIUS**2
    assert (np.abs(ellipse.centre - values[0]) < limit * elements.centre_sigma).all()
    radius = ellipse.semi_axes.mean()
    assert abs(radius - RADIUS) < limit * elements.semi_axes_sigma[0] + 0.001  # the spline's model error
    assert np.linalg.norm(np.cross(ellipse.normal, normal)) < limit * elements.normal_sigma_rad


def test_model_error_of_the_spline() -> None:
    """Without noise: a circle, conic and Fourier curve are exact, the spline keeps within 7e-4 of the radius."""
    result = adjusted(0.0)
    for name in ("as-conic", "as-fourier"):
        assert (
            compare_curves(curve(result, name), curve(result, "as-circle")).distance.max()
            < 2e-4 * 1e-2 * RADIUS
        )
    found = compare_curves(curve(result, "as-spline"), curve(result, "as-circle"))
    assert 5e-4 * RADIUS < found.distance.max() < 7e-4 * RADIUS
    assert 3.5e-4 * RADIUS < found.rms < 4.5e-4 * RADIUS


def test_comparison_sees_a_difference_of_shape() -> None:
    """A circle 30 mm larger is not the same; a conic that is not round neither."""
    result = adjusted(5.0)
    one = curve(result, "as-circle")
    values = one.result.values.copy()
    values[1:] *= 1.0 + 0.03 / RADIUS
    larger = replace(one, result=replace(one.result, values=values, sample_xyz=one.result.sample_xyz))
    found = compare_curves(curve(result, "as-spline"), larger)
    assert np.mean(found.normalized**2) > FIVE
    assert found.rms > 0.025


def test_comparison_is_symmetric_and_zero_of_a_curve_with_itself() -> None:
    result = adjusted(5.0)
    spline, fourier = curve(result, "as-spline"), curve(result, "as-fourier")
    assert compare_curves(spline, spline).distance.max() < 1e-9
    there, back = compare_curves(spline, fourier), compare_curves(fourier, spline)
    assert back.rms == pytest.approx(there.rms, rel=0.1)
    assert back.sigma_rms == pytest.approx(there.sigma_rms, rel=0.1)


def test_parts_beyond_an_open_end_are_left_out() -> None:
    result = adjusted(5.0)
    one = curve(result, "as-circle")
    arc = replace(one, curve=replace(one.curve, knot_parameters=np.array([0.2, 2.0]), closed=False))
    inside = (one.result.sample_u > 0.2) & (one.result.sample_u < 2.0)
    arc = replace(arc, result=replace(arc.result, sample_u=np.linspace(0.2, 2.0, len(one.result.sample_u))))
    found = compare_curves(one, arc)
    assert inside.sum() <= len(found.u) < len(one.result.sample_u)
    far = replace(one, result=replace(one.result, sample_xyz=one.result.sample_xyz + [0.0, -500.0, 0.0]))
    with pytest.raises(ValueError, match="no part in common"):
        compare_curves(far, arc)


def test_large_coordinates_cost_no_digits() -> None:
    """The user's frame 7 600 km away: the same distances to a micrometre."""
    near, far = adjusted(5.0), adjusted(5.0, origin=7_600_000.0)
    for first, second in (("as-circle", "as-spline"), ("as-fourier", "as-conic")):
        found, expected = (compare_curves(curve(r, first), curve(r, second)) for r in (far, near))
        np.testing.assert_allclose(found.distance, expected.distance, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(found.sigma, expected.sigma, rtol=1e-4)


def test_two_curves_have_two_dimensions_across() -> None:
    """Their normal planes differ a little; the small variance along the curves that this makes is left out."""
    one, other = (adjust(simulate_block("circle-three-ways", seed)[0]) for seed in (1, 2))
    found = compare_curves(curve(one, "as-fourier"), curve(other, "as-fourier"))
    assert (found.dimensions == 2).all()
    assert found.normalized.max() < 3.5  # chi-square of two degrees: beyond once in 2e5
