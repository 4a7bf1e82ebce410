"""Adjustments with arc lengths and tangents: truth without noise, counts, ways round closed curves, both rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.observations.arc_lengths import linearize_arc_lengths
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth, at_truth, true_state
from tests.core.free_curves import CUBIC, LINE, block_with, tie

SIGMA_MM, SIGMA_RAD = 0.007, 0.01


def linked(network: Network, truth: Truth, seed: int | None) -> Network:
    generator = None if seed is None else np.random.default_rng(seed)
    return with_tangents(
        with_arc_lengths(network, truth, SIGMA_MM, generator), truth, SIGMA_RAD, generator, directed=True
    )


def eop_errors(result: AdjustmentResult, network: Network, truth: Truth) -> FloatArray:
    errors = result.images.eop - truth.eop
    errors[:, 3:] -= network.origin
    errors[:, :3] = np.mod(errors[:, :3] + np.pi, 2.0 * np.pi) - np.pi
    return errors


@pytest.mark.parametrize("kind", ["six-image", "strip"])
def test_without_noise_the_truth_comes_back(kind: str) -> None:
    network, truth = simulate_block(kind, seed=3, noise_um=0.0)
    result = adjust(linked(network, truth, None))
    assert np.abs(eop_errors(result, network, truth)[:, 3:]).max() < 1e-6
    assert result.statistics.sigma0 < 1e-6


def test_counts_and_sum_of_redundancy_numbers() -> None:
    network, truth = simulate_block("six-image", seed=4)
    plain, found = adjust(network).statistics, adjust(linked(network, truth, 1)).statistics
    more = len(linked(network, truth, 1).arc_lengths) + len(network.curve_observations)
    assert found.observations == plain.observations + more
    assert found.redundancy == plain.redundancy + more
    assert found.sum_redundancy_numbers == pytest.approx(found.redundancy, abs=1e-6)


def test_lines_and_cubics_with_tangents_alone() -> None:
    """Tangents are meant for straight lines: they add redundancy, and remove no gauge."""
    network, truth = block_with(tie("line", "straight_line", LINE), tie("cubic", "free_cubic", CUBIC))
    result = adjust(with_tangents(network, truth, SIGMA_RAD, np.random.default_rng(2)))
    assert result.statistics.rank_defect == 4
    assert (result.tangent_residuals.redundancy > 0.9).all()
    w = result.tangent_residuals.standardized
    assert 0.7 < np.sqrt(np.mean(w**2)) < 1.3  # some 140 values


def test_a_longer_measured_arc_goes_the_other_way_round() -> None:
    network, truth = simulate_block("six-image", noise_um=0.0)
    lake = next(k for k, curve in enumerate(network.curves) if curve.closed)
    rows = np.flatnonzero(network.curve_observations.curve == lake)[:2]
    full = with_arc_lengths(network, truth, SIGMA_MM, None)
    pair = int(
        np.flatnonzero(np.isin(full.arc_lengths.first, rows) & np.isin(full.arc_lengths.second, rows))[0]
    )
    picked = {
        name: getattr(full.arc_lengths, name)[[pair]]
        for name in ("first", "second", "length", "sigma", "simpson")
    }
    one = replace(full, arc_lengths=replace(full.arc_lengths, **picked))
    far = truth.locations.copy()
    start, end = one.arc_lengths.first[0], one.arc_lengths.second[0]
    far[end] = np.mod(far[start] + 3.4, 8.0)  # 3.4 of 8 segments ahead, 4.6 behind
    moved = replace(truth, locations=far)
    prepared = prepare(at_truth(one, moved))
    state = true_state(prepared, moved)
    ahead = linearize_arc_lengths(prepared, state).residual[0] * SIGMA_MM + one.arc_lengths.length[0]
    measured = replace(one, arc_lengths=replace(one.arc_lengths, length=np.array([2.0 * ahead])))
    prepared = prepare(at_truth(measured, moved))
    behind = linearize_arc_lengths(prepared, true_state(prepared, moved)).residual[0] * SIGMA_MM + 2.0 * ahead
    assert behind > 1.1 * ahead


def close_arcs(network: Network, truth: Truth, largest: float, *, simpson: bool) -> Network:
    """Arc lengths between points at most `largest` segments apart."""
    full = with_arc_lengths(network, truth, SIGMA_MM, np.random.default_rng(1), simpson=simpson)
    arcs = full.arc_lengths
    keep = np.abs(truth.locations[arcs.second] - truth.locations[arcs.first]) <= largest
    names = ("first", "second", "length", "sigma", "simpson")
    return replace(full, arc_lengths=replace(arcs, **{name: getattr(arcs, name)[keep] for name in names}))


def test_both_rules_agree_on_close_points() -> None:
    """Up to a seventh of a segment Simpson's bias stays far below the noise; nothing is said of it."""
    network, truth = simulate_block("six-image", seed=5)
    first = adjust(close_arcs(network, truth, 0.15, simpson=False))
    other = adjust(close_arcs(network, truth, 0.15, simpson=True))
    sigma = np.sqrt(np.einsum("mii->mi", first.images.dispersion))
    assert np.abs((other.images.eop - first.images.eop) / sigma).max() < 0.05
    assert "SBB537" not in [problem.code for problem in other.problems]


def test_a_long_simpson_step_is_named() -> None:
    network, truth = simulate_block("six-image", seed=5, start_position_m=0.5, start_angle_deg=0.1)
    result = adjust(close_arcs(network, truth, 0.8, simpson=True))
    found = [problem.message for problem in result.problems if problem.code == "SBB537"]
    assert len(found) == 1 and "largest" in found[0]
