"""The best sequence of depths, against all sequences."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.consensus import Depths
from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses
from splinebba_cli.core.matching.fragments.labelling import BREAK, SHARED, best_depths, depth_jump
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import IntArray

LENGTHS = (5, 3, 4)


def random_case(seed: int) -> tuple[TracedChains, Hypotheses, Depths, IntArray]:
    """Three pieces with none to three depths a point, whose chains are pieces 3 and 4."""
    generator = np.random.default_rng(seed)
    points = np.arange(sum(LENGTHS))
    piece = np.concatenate([np.repeat(np.arange(3), LENGTHS), [3, 3, 4, 4]])
    total = len(piece)
    count = generator.integers(0, 4, len(points))
    point = np.repeat(points, count)
    states = len(point)
    chains = TracedChains(
        row=np.arange(total), image=np.zeros(total, dtype=np.int64), piece=piece,
        start=np.flatnonzero(np.diff(piece, prepend=-1, append=9)), xy=np.zeros((total, 2)),
        arc=np.arange(total, dtype=float), tangent=np.zeros((total, 2)), tangent_sigma=np.zeros(total),
        sigma=np.zeros(total), ray=np.zeros((total, 3)),
    )  # fmt: skip
    found = Hypotheses(
        point, np.full(states, 1), generator.choice([12.0, 14.0], states), np.zeros(states), np.zeros(states),
        np.zeros(states), np.zeros(states),
    )  # fmt: skip
    depths = Depths(
        point, generator.normal(0.0, 2.0, states), np.ones(states), generator.normal(0.0, 1.0, states),
        np.full(states, 0.5), generator.uniform(0.0, 8.0, states), np.arange(states)[:, None],
    )  # fmt: skip
    return chains, found, depths, points


def worth_of(chains: TracedChains, found: Hypotheses, depths: Depths, states: tuple[int, ...]) -> float:
    """The objective of the module's first lines."""
    total = sum(depths.worth[s] for s in states if s >= 0)
    for a, b in pairwise(states):
        if a < 0 or b < 0:
            total -= 0.0 if a == b else 0.5 * BREAK
            continue
        z = depth_jump(
            depths.depth[a], depths.sigma[a], depths.slope[a], depths.slope_sigma[a],
            depths.depth[b], depths.sigma[b], depths.slope[b], depths.slope_sigma[b], 1.0,
        )  # fmt: skip
        same = chains.piece[int(found.place[a])] == chains.piece[int(found.place[b])]
        total -= 0.5 * z**2 - SHARED * same if 0.5 * z**2 < BREAK else BREAK
    return float(total)


@pytest.mark.parametrize("seed", range(12))
def test_no_sequence_is_worth_more(seed: int) -> None:
    chains, found, depths, points = random_case(seed)
    state, joined = best_depths(chains, found, depths, points)
    for first, last in zip(chains.start[:3], chains.start[1:4], strict=True):
        choices = [[*np.flatnonzero(depths.point == p), -1] for p in range(first, last)]
        best = max(worth_of(chains, found, depths, states) for states in product(*choices))
        assert worth_of(chains, found, depths, tuple(state[first:last])) == pytest.approx(best)
        assert not joined[first]
    assert (depths.point[state[state >= 0]] == points[state >= 0]).all()
    assert not joined[state < 0].any()


def test_a_curve_that_bends_evenly_does_not_jump() -> None:
    """Depth 1 + s^2 from s = 0 to 1: the slopes 0 and 2 explain it by their mean."""
    assert depth_jump(*map(np.float64, (1.0, 0.1, 0.0, 0.2, 2.0, 0.1, 2.0, 0.2)), 1.0) == 0.0
    sigma = np.sqrt(2.0 * 0.1**2 + 2.0 * 0.5**2 * 0.2**2)
    jump = depth_jump(*map(np.float64, (1.0, 0.1, 0.0, 0.2, 2.5, 0.1, 2.0, 0.2)), 1.0)
    assert jump == pytest.approx(0.5 / sigma)
