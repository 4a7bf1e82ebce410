"""Dispersion across curves of every family: errors across over their predicted sigma, 60 seeded runs of one design.

One curve of each family in the six images with known orientations, 12 points an image, 5 µm. At the middle of each
segment of the adjusted curve, e is the distance across from the true curve, C the lateral dispersion (a priori sigma0),
and e'C^+e has the mean 2. Over a curve the places are correlated; they come from at least as many independent unknowns
as the curve has across, at least 4. The mean of e'C^+e / 2 over N runs lies therefore within the interval of chi-square
with 4 N degrees of freedom; for all curves together with 1 - 1e-3 probability (Bonferroni over the curves).

Curves whose places along them are held by conditions are linear in no direction that matters: bias of the second order
is below a hundredth of sigma at this scale.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray, Settings
from splinebba_cli.core.quality.curve_comparison import AdjustedCurve, compare_curves
from splinebba_cli.core.result import CurveResult
from splinebba_cli.simulation.assembly import assemble
from splinebba_cli.simulation.block_geometry import six_image_block
from splinebba_cli.simulation.feature_geometry import PointFeatures
from splinebba_cli.simulation.monte_carlo import mean_square_interval
from splinebba_cli.simulation.noise import Noise
from tests.core.family_features import ALL, joined, of_family, with_options

RUNS = 60
FAMILIES = (
    "natural_cubic",
    "straight_line",
    "free_cubic",
    "cardinal",
    "bspline_2",
    "fourier",
    "conic",
    "circle",
)
CURVES = (
    *(of_family(name) for name in FAMILIES),
    joined(3, 2, natural=True),
    with_options(next(f for f in ALL if f.id == "bspline_3-closed")),
    next(f for f in ALL if f.id == "circular-arc"),
)
NAMES = tuple(feature.id for feature in CURVES)


def exact(found: CurveResult, number: int) -> AdjustedCurve:
    """The true curve as if it were an adjusted one without dispersion."""
    feature = CURVES[number]
    result = replace(found, values=feature.values, sample_across=np.zeros_like(found.sample_across))
    return AdjustedCurve(feature.curve(feature.values), result)


@cache
def squares() -> FloatArray:
    """Mean of e'C^+e / 2 over the places of each curve, (runs, curves)."""
    out = np.zeros((RUNS, len(CURVES)))
    for seed in range(RUNS):
        network, truth = assemble(
            six_image_block(), CURVES, PointFeatures(), 12, None, Noise(5e-3, 0.0, 0.0, 0.1), seed + 1
        )
        images = replace(network.images, prior=truth.eop.copy(), prior_sigma=np.zeros_like(truth.eop))
        images = replace(images, rotation=truth.rotation, position=truth.eop[:, 3:].copy())
        settings = Settings(scale_dispersion=False)
        result = adjust(replace(network, images=images, settings=settings))
        for k, found in enumerate(result.curves):
            mine = AdjustedCurve(result.network.curves[k], found)
            out[seed, k] = np.mean(compare_curves(mine, exact(found, k)).normalized ** 2)
    return out


@pytest.mark.parametrize("name", NAMES)
def test_errors_across_follow_the_dispersion(name: str) -> None:
    mean = squares()[:, NAMES.index(name)].mean()
    lower, upper = mean_square_interval(4 * RUNS, 1.0 - 1e-3 / len(CURVES))
    assert lower < mean < upper
