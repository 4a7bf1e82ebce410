"""The variance of unit weight of rounds against sampling: clean points, too small sigma, wrong labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contaminated import with_moved_orientations
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from splinebba_cli.core.matching.known_curves.round_network import Labels
from splinebba_cli.core.matching.known_curves.unit_variance import UnitVariance
from splinebba_cli.core.matching.settings import MatchSettings
from tests.core.matching.known_curves.one_image import ROADS, SIGMA_MM, control, network, seen

COUNT, RUNS = 60, 40
POSITION, ANGLE = 1.0, 0.002  # of the prior
CURVES = [control(values, f"road-{k}") for k, values in enumerate(ROADS)]
PLACES = np.concatenate([np.linspace(*basis_of(curve).break_points[[0, -1]], COUNT) for curve in CURVES])
EXACT = [seen(curve, COUNT) for curve in CURVES]
REDUNDANCY = 2 * COUNT  # six unknowns, six values of the prior
DEVIATION = 1.0 / np.sqrt(2.0 * REDUNDANCY * RUNS)  # of the mean of RUNS values of sigma0
EFFICIENCY = 1.25  # more, where outer points have less weight


def mean_sigma0(noise: float, wrong: float, *, robust: bool) -> float:
    """Mean over adjustments of all points with their labels.

    Parameters
    ----------
    noise : in the stated sigma
    wrong : share of points that are up to 15 sigma off
    """
    generator, found = np.random.default_rng(1), []
    for _ in range(RUNS):
        chains = [xy + generator.normal(0.0, noise * SIGMA_MM, xy.shape) for xy in EXACT]
        for xy in chains:
            off = generator.random(COUNT) < wrong
            xy[off] += generator.uniform(-15.0, 15.0, (int(off.sum()), 2)) * SIGMA_MM
        given = with_moved_orientations(network(CURVES, chains), generator, POSITION, ANGLE)
        context = LoopContext.of(given, MatchSettings(position_sigma_m=POSITION, angle_sigma_rad=ANGLE), None)
        labels = Labels(np.repeat([0, 1], COUNT), PLACES)
        solved = context.adjust(
            replace(context.begin(), labels=labels), context.start.known, context.start.network, 12, robust=robust
        )  # fmt: skip
        assert solved is not None
        found.append(solved.fit.sigma0)
    return float(np.mean(found))


@pytest.mark.parametrize("robust", [False, True])
def test_of_clean_points_it_is_one(robust: bool) -> None:
    """The mean is inside of 4.4 of its standard deviations with 99.999 %."""
    assert abs(mean_sigma0(1.0, 0.0, robust=robust) - 1.0) < 4.4 * EFFICIENCY * DEVIATION


def test_of_points_worse_than_stated_it_says_so() -> None:
    assert abs(mean_sigma0(2.5, 0.0, robust=True) / 2.5 - 1.0) < 4.4 * EFFICIENCY * DEVIATION


def test_wrong_labels_hardly_count() -> None:
    assert abs(mean_sigma0(1.0, 0.15, robust=True) - 1.0) < 0.3
    assert mean_sigma0(1.0, 0.15, robust=False) > 3.0


def test_only_residuals_that_refute_the_stated_sigma_widen_the_gate() -> None:
    """Of 1000 redundant points sigma0 exceeds 1.069 once in a thousand times."""
    assert UnitVariance(1.05**2, 1000.0).noise == 1.0
    assert UnitVariance(1.09**2, 1000.0).noise == pytest.approx(1.09)
    assert UnitVariance(1.09**2, 100.0).noise == 1.0
    assert UnitVariance(np.nan, 0.0).noise == 1.0
