"""Points near curves by chance are told by the distribution of their distances."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.known_curves.chance_hits import likely_by_chance

GATE = 3.29


def test_of_points_on_curves_hardly_any_is_lost() -> None:
    x = np.abs(np.random.default_rng(1).normal(size=5000))
    assert np.mean(likely_by_chance(x[x < GATE], GATE)) < 0.005


def test_where_all_is_chance_nothing_is_taken() -> None:
    x = np.random.default_rng(1).uniform(0.0, GATE, 1000)
    assert np.mean(likely_by_chance(x, GATE)) > 0.9


def test_a_mixture_is_cut_where_both_are_equally_likely() -> None:
    """With as many points of chance, 2 phi(x) = 1 / g at x = 1.39."""
    generator = np.random.default_rng(1)
    x = np.concatenate([np.abs(generator.normal(size=20_000)), generator.uniform(0.0, GATE, 20_000)])
    x = x[x < GATE]
    kept = x[~likely_by_chance(x, GATE)]
    assert abs(kept.max() - np.sqrt(-2.0 * np.log(np.sqrt(np.pi / 2.0) / GATE))) < 0.1


def test_few_points_tell_nothing() -> None:
    assert not likely_by_chance(np.full(5, 3.0), GATE).any()
