"""Strips of a block, and shifts and drifts of their prior positions."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse, stats

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.quality.strip_drifts import _worst, strips_of
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.six_image_block import simulate_block


def test_strips_end_where_the_flight_turns_or_jumps() -> None:
    there = np.column_stack([np.arange(5) * 100.0, np.zeros(5), np.full(5, 500.0)])
    back = there[::-1] + [0.0, 300.0, 0.0]
    onward = there + [900.0, 300.0, 0.0]
    found = strips_of(np.vstack([there, back]) + np.random.default_rng(1).normal(0.0, 5.0, (10, 3)))
    assert [strip.tolist() for strip in found] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
    assert [len(strip) for strip in strips_of(np.vstack([there, onward]))] == [5, 5]
    assert [len(strip) for strip in strips_of(there[:1])] == [1]


def strip_block(seed: int) -> Network:
    """Five images in a strip with observed orientations; positions known to 5 cm, heights to 8 cm."""
    return simulate_block("strip", seed, start_position_m=0.3, start_angle_deg=0.05, start_knots_m=0.3)[0]


def with_error(network: Network, shift: FloatArray, drift: FloatArray) -> Network:
    prior = network.images.prior.copy()
    prior[:, 3:] += shift + np.linspace(-1.0, 1.0, len(prior))[:, None] * drift
    return replace(network, images=replace(network.images, prior=prior))


def effect_of(result: AdjustmentResult) -> SystematicEffect:
    (found,) = [each for each in result.evidence.systematic if each.kind == "strip"]
    return found


def test_a_drift_is_found_and_named() -> None:
    wrong = with_error(strip_block(2), np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.4, 0.0]))
    result = adjust(wrong)
    found = effect_of(result)
    assert found.significant and found.subject == "prior positions of images `1` to `5`"
    (problem,) = [each for each in result.problems if each.code == "SBB550" and each.subject == found.subject]
    assert "drift to the last image" in problem.message and problem.severity == "warning"


def test_the_correction_takes_the_statistic_out_of_the_cost() -> None:
    """v'Pv falls by T when the priors are corrected by the estimate: 1e-3, the block is nearly linear."""
    wrong = with_error(strip_block(2), np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.4, 0.0]))
    before = adjust(wrong)
    found = effect_of(before)
    numbers = [
        [float(v.replace("−", "-")) for v in part.split(")")[0].split(", ")]
        for part in found.detail.split("(")[1:]
    ]
    after = adjust(with_error(wrong, -np.array(numbers[0]), -np.array(numbers[1])))
    fall = before.statistics.vtpv - after.statistics.vtpv
    assert fall == pytest.approx(found.statistic, rel=0.02)  # the estimate is printed with two digits


def test_without_an_error_the_statistic_is_chi_square() -> None:
    """Mean of T over 40 blocks within 4 of its standard deviations, sqrt(2 q / 40)."""
    effects = [effect_of(adjust(strip_block(100 + seed))) for seed in range(40)]
    q = 6
    assert np.mean([each.statistic for each in effects]) == pytest.approx(q, abs=4.0 * np.sqrt(2.0 * q / 40))
    alarms = sum(each.significant for each in effects)
    assert alarms <= stats.binom.ppf(0.9999, 40, 0.05)


def test_where_not_all_are_affordable_the_most_suspicious_are_tested() -> None:
    """Size is C'v over |C|: not that of the biases themselves."""
    residual = np.array([0.5, 3.0, 1.0, 2.0])
    blocks = [sparse.csc_array(np.eye(4)[:, [k]] * scale) for k, scale in enumerate((100.0, 1.0, 10.0, 0.1))]
    for affordable, expected in ((2, [1]), (3, [1, 3]), (5, [1, 2, 3]), (6, [0, 1, 2, 3])):
        projector = SimpleNamespace(affordable=affordable, design=SimpleNamespace(residual=residual))
        assert _worst(projector, blocks) == expected  # type: ignore[arg-type]
