"""A start that gross errors do not spoil: what it takes out, and that the stages then see nothing of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.blunder_cases import (
    clean_block,
    contaminated,
    in_coordinate,
    largest_shift,
    planted_rows,
    with_policy,
)
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.settings import OutlierPolicy
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.revision.test_data_snooping import clean

ROBUST = OutlierPolicy("snooping", "high_breakdown", max_share=0.5)
SHARE, SEED = 0.3, 5


def test_three_in_ten_errors_are_taken_out_and_the_good_ones_return() -> None:
    """Errors of 20 σ and more stand clear of noise; some fall near another stretch of their curve."""
    block = clean()
    result = adjust(with_policy(contaminated(block, SHARE, SEED), ROBUST))
    rows = set(planted_rows(block, SHARE, SEED)[0].tolist())
    gone = {each.row for each in result.revision.rejections if each.kind == "spline" and not each.returned}
    assert len(rows - gone) <= 0.02 * len(rows)
    good = len(block.network.curve_observations) - len(rows)
    assert len(gone - rows) <= 0.03 * good
    assert largest_shift(block.result, result) < 3.0
    assert result.revision.start == "high_breakdown"
    assert any(each.round == 0 for each in result.revision.rejections)


def test_badly_spaced_knots_are_no_reason_to_reject() -> None:
    """Knots wrong by up to 10 m of 100: held there they bend the curves wrongly, and hundreds of good points fail."""
    seed, kind = 4, "six-image"
    block = clean_block(seed, kind)
    rough = simulate_block(kind, seed, start_knots_m=10.0)[0]
    curves = tuple(replace(curve, reference=None) for curve in rough.curves)
    network = replace(contaminated(block, 0.2, seed), curves=curves)
    result = adjust(with_policy(network, ROBUST))
    assert largest_shift(block.result, result) < 3.0
    assert result.revision.rejected <= 1.1 * len(planted_rows(block, 0.2, seed)[0])


def test_the_adjustment_goes_on_from_the_solution_of_the_start() -> None:
    """Stages of their own would begin with shapes that the start has left."""
    result = adjust(with_policy(contaminated(clean(), 0.1, SEED), ROBUST))
    stages = {each.stage for each in result.iterations}
    assert {"start", "joint"} <= stages
    assert not {"points", "control", "curves"} & stages


def test_it_is_the_same_every_time() -> None:
    network = with_policy(contaminated(clean(), 0.1, SEED), ROBUST)
    first, second = adjust(network), adjust(network)
    np.testing.assert_array_equal(first.images.eop, second.images.eop)
    assert first.revision.rejections == second.revision.rejections


def test_without_errors_it_ends_where_least_squares_ends() -> None:
    """What it takes out and snooping would not comes back: both reject the same."""
    network = clean().network
    plain = adjust(with_policy(network, OutlierPolicy("snooping")))
    robust = adjust(with_policy(network, ROBUST))
    standing = [
        {(each.kind, each.row) for each in result.revision.rejections if not each.returned}
        for result in (plain, robust)
    ]
    assert standing[0] == standing[1]
    sigma = np.sqrt(np.einsum("mii->mi", plain.images.dispersion))
    assert (np.abs(robust.images.eop - plain.images.eop) < 1e-3 * sigma).all()


def test_errors_in_points_do_not_break_the_first_stage() -> None:
    """Ten of 124 image points wrong by 2 mm: the points-only stage would start from there."""
    block = clean_block(4)
    network = block.network
    seen = network.point_observations
    rays = np.bincount(seen.point)
    rows = np.flatnonzero((rays >= 4)[seen.point])[::5][:10]
    for row in rows:
        network = in_coordinate(network, int(row), int(row) % 2, 400.0)
    result = adjust(with_policy(network, ROBUST))
    gone = {each.row for each in result.revision.rejections if each.kind == "point" and not each.returned}
    assert set(rows.tolist()) <= gone
    assert largest_shift(block.result, result) < 3.0
