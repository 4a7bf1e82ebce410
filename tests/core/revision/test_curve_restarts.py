"""Curves started anew: out of a false minimum, one by one, orientations untouched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.blunder_cases import clean_block, contaminated, planted_rows
from splinebba_cli.core.revision.curve_restarts import restarted
from splinebba_cli.core.revision.graduated_weights import graduated
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import true_state

KIND, SEED, SHARE, SLIDING = "six-image", 18, 0.4, 0.003


def test_shapes_of_false_minima_are_left_and_the_others_stay() -> None:
    """Begun with wide scales at true orientations, two curves keep gross errors that a narrower start throws out.

    An error of 20 sigma and more cannot have a weight above 1 / (1 + (20 / 3)^2)^2 = 0.0005 on its true curve; on a
    curve that gives way to it, it has.
    """
    clean = clean_block(SEED, KIND)
    prepared = prepare(contaminated(clean, SHARE, SEED))
    bad = planted_rows(clean, SHARE, SEED)[0] + len(prepared.network.point_observations)
    truth = true_state(prepared, simulate_block(KIND, SEED, noise_um=0.0)[1])
    unknown = np.full(len(truth.location), np.nan)
    start = replace(truth, location=unknown)
    held = WeightedNetwork(prepared, start, None, None, "start", SLIDING)
    every = np.ones(len(held.listed))
    factor, state = graduated(held, start, every)
    kept = (factor[bad] > 0.05).sum()
    weights, after = restarted(prepared, held.listed, start, state, every, SLIDING)
    assert kept >= 3
    assert (weights[bad] > 0.05).sum() <= 0.5 * kept
    assert weights.sum() > factor.sum()
    np.testing.assert_array_equal(after.rotation, state.rotation)
    np.testing.assert_array_equal(after.position, state.position)


def test_a_curve_without_a_better_shape_keeps_its_own() -> None:
    clean = clean_block(SEED, KIND)
    prepared = prepare(clean.network)
    truth = true_state(prepared, simulate_block(KIND, SEED, noise_um=0.0)[1])
    held = WeightedNetwork(prepared, truth, None, None, "start", SLIDING)
    every = np.ones(len(held.listed))
    factor, state = graduated(held, truth, every)
    wrong = replace(truth, coefficients=truth.coefficients + 500.0)
    weights, after = restarted(prepared, held.listed, wrong, state, every, SLIDING)
    np.testing.assert_allclose(weights, factor, atol=0.02)
    assert np.abs(after.coefficients - state.coefficients).max() < 0.05
