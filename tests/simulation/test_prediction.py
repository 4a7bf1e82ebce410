"""Pre-analysis: the predicted dispersion is that of an adjustment of noise-free measurements of the same design."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Datum
from splinebba_cli.errors import SingularNetworkError
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.prediction import predict, redundancy_summary
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.six_image_block import kind_design

RELATIVE = 1e-6  # of σ: the iterations end within 1e-6 σ of the truth, where dispersions change by less


@pytest.mark.parametrize("kind", ["six-image", "six-image-mixed", "strip"])
def test_prediction_equals_a_noise_free_adjustment(kind: str) -> None:
    """From wrong starts, so that the adjustment has something to do."""
    design = kind_design(kind, 0.005)
    made = realize(design, Noise(0.0, 1.0, 0.005, 0.5), 1)
    network = replace(made.network, settings=replace(made.network.settings, scale_dispersion=False))
    predicted, found = predict(design), adjust(network)
    np.testing.assert_allclose(
        predicted.images.dispersion, found.images.dispersion, rtol=RELATIVE, atol=1e-20
    )
    np.testing.assert_allclose(
        predicted.points.dispersion, found.points.dispersion, rtol=RELATIVE, atol=1e-16
    )
    for one, other in zip(predicted.curves, found.curves, strict=True):
        np.testing.assert_allclose(one.sample_across, other.sample_across, rtol=RELATIVE, atol=1e-9)
    assert predicted.statistics.redundancy == found.statistics.redundancy
    assert predicted.statistics.conditions == found.statistics.conditions
    np.testing.assert_allclose(
        predicted.curve_residuals.redundancy, found.curve_residuals.redundancy, atol=1e-6
    )


def test_prediction_says_nothing_about_residuals() -> None:
    result = predict(kind_design("six-image", 0.005))
    assert np.isnan(result.statistics.sigma0) and result.statistics.global_test is None
    assert "SBB531" not in [problem.code for problem in result.problems]


def test_twice_the_noise_is_twice_the_sigma_without_control_errors() -> None:
    """Held control, no priors: σ scales with the noise; one control height of 5 cm does not."""
    one, two = (predict(kind_design("six-image", s)) for s in (1e-6, 2e-6))
    ratio = np.sqrt(np.diagonal(two.images.dispersion / one.images.dispersion, axis1=1, axis2=2))
    np.testing.assert_allclose(ratio, 2.0, rtol=1e-3)


def test_redundancy_numbers_are_summed_up_by_kind() -> None:
    result = predict(kind_design("strip", 0.005))
    summary = {each.kind: each for each in redundancy_summary(result)}
    assert {"points, x and y", "points on splines, across", "control point", "eop prior"} <= set(summary)
    total = sum(each.count * each.mean for each in summary.values())
    assert total == pytest.approx(result.statistics.redundancy, abs=1e-4)


def test_what_would_not_be_determined_is_named() -> None:
    with pytest.raises(SingularNetworkError) as refused:
        predict(kind_design("six-image-singular", 0.005))
    assert [problem.subject for problem in refused.value.problems] == [f"image `{k}`" for k in range(1, 7)]


def test_minimal_datum() -> None:
    """Without control, seven unknowns are held; their predicted σ is 0."""
    design = kind_design("six-image-mixed", 0.005)
    datum: Datum = "minimal"
    network = design.network
    free = replace(
        network,
        settings=replace(network.settings, datum=datum),
        points=replace(
            network.points,
            role=tuple("tie" if r == "control" else r for r in network.points.role),
            sigma=np.full_like(network.points.sigma, np.inf),
        ),
        curves=tuple(replace(c, sigma=np.full_like(c.sigma, np.inf)) for c in network.curves),
    )
    result = predict(Design(free, design.truth))
    sigma = np.sqrt(np.diagonal(result.images.dispersion, axis1=1, axis2=2))
    assert (sigma == 0.0).sum() == 7


def test_circles_keep_their_shape_conditions() -> None:
    """A circle in four images: conditions of shape and gauge as an adjustment has them, σ of the radius like its."""
    design = kind_design("circle-three-ways", 0.005)
    predicted = predict(design).statistics
    assert predicted.redundancy == pytest.approx(predicted.sum_redundancy_numbers, abs=1e-6)
    found = adjust(realize(design, Noise(start_position_m=0.1, start_knots_m=0.05), 3).network).statistics
    assert (predicted.conditions, predicted.redundancy) == (found.conditions, found.redundancy)


def test_arc_lengths_and_tangents_are_summed_up() -> None:
    design = kind_design("six-image", 0.005)
    network = with_tangents(
        with_arc_lengths(design.network, design.truth, 0.007, None), design.truth, 0.01, None
    )
    kinds = {
        summary.kind: summary for summary in redundancy_summary(predict(replace(design, network=network)))
    }
    assert kinds["arc lengths"].count == len(network.arc_lengths)
    assert 0.9 < kinds["tangents"].mean < 1.0  # an angle of 0.6° says little beside points of 5 µm


def test_a_prediction_has_no_findings_of_residuals() -> None:
    """There are no measured values: nothing fails a test, agrees or runs along a curve."""
    found = predict(kind_design("six-image-mixed", 0.005)).problems
    allowed = {"SBB532", "SBB533", "SBB534", "SBB553"}
    assert {problem.code for problem in found} <= allowed
