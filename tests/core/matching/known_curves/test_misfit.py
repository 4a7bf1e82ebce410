"""Warnings about matched points that do not fit, and about a principal distance that they contradict."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contaminated import with_moved_orientations
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem
from tests.core.matching.known_curves.one_image import SIGMA_MM, control, network, seen

SETTINGS = MatchSettings(position_sigma_m=5.0, angle_sigma_rad=0.01)
HILLS = (
    [(-150, -100, 10), (-50, 30, 80), (50, -40, 5), (150, 120, 60)],
    [(-100, 120, 90), (-20, 30, 2), (50, -140, 70)],
    [(-140, 60, 40), (0, 110, 100), (130, 20, 10)],
)


def hills(noise: float = 1.0, seed: int = 1) -> Network:
    """Three roads over hills, 40 points each; noise in the stated sigma."""
    curves = [control(values, f"road-{k}") for k, values in enumerate(HILLS)]
    generator = np.random.default_rng(seed)
    chains = [seen(curve, 40) + generator.normal(0.0, noise * SIGMA_MM, (40, 2)) for curve in curves]
    return with_moved_orientations(network(curves, chains), generator, 1.0, 0.002)


def with_principal_distance(given: Network, factor: float) -> Network:
    (camera,) = given.cameras
    wrong = replace(camera, principal_distance_mm=factor * camera.principal_distance_mm)
    return replace(given, cameras=(wrong,))


def problems(given: Network) -> dict[str, Problem]:
    return {problem.code: problem for problem in match(given, SETTINGS).problems}


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_nothing_is_said_of_a_good_network(seed: int) -> None:
    assert problems(hills(seed=seed)) == {}


def asked(given: Network) -> tuple[float, float]:
    """The principal distance of SBB585 and its sigma."""
    message = problems(given)["SBB585"].message
    value, sigma = map(float, re.findall(r"of ([\d.]+) ± ([\d.]+) mm", message)[0])
    return value, sigma


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_the_principal_distance_that_points_ask_for(factor: float) -> None:
    """150 mm are right; the stated uncertainty counts a fifth of the points as independent."""
    value, sigma = asked(with_principal_distance(hills(), factor))
    assert abs(value - 150.0) < 3.0 * sigma
    assert abs(value - factor * 150.0) > 4.0 * sigma


def test_a_fifth_of_the_points_of_chains_is_independent() -> None:
    """The same points, single, say the same with a smaller sigma."""
    chained = with_principal_distance(hills(), 1.01)
    points = chained.unlabelled
    single = replace(points, chain=np.full(len(points), -1), chain_ids=())
    value, sigma = asked(chained)
    of_single, sigma_single = asked(replace(chained, unlabelled=single))
    assert sigma / sigma_single == pytest.approx(np.sqrt(5.0), rel=0.1)
    assert abs(of_single - value) < sigma


def test_no_verdict_where_nothing_contradicts() -> None:
    """A change by 0.02 % takes away less than a tenth of the noise."""
    assert problems(with_principal_distance(hills(), 1.0002)) == {}


def test_points_worse_than_stated_are_told() -> None:
    found = problems(hills(noise=2.0))
    assert set(found) == {"SBB593"}
    sigma0, limit = map(
        float, re.findall(r"σ̂₀ ([\d.]+), by chance at most ([\d.]+)$", found["SBB593"].message)[0]
    )
    assert sigma0 == pytest.approx(2.0, abs=0.5)  # a gate has cut the largest residuals
    assert limit == pytest.approx(1.0 + 3.1 / np.sqrt(2.0 * 114.0), abs=0.03)
