"""Directions of edges from chains."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.known_curves.chain_directions import ChainOrder, chain_directions
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from splinebba_cli.core.network import FloatArray
from tests.core.matching.known_curves.one_image import GOOD, SIGMA_MM, control, network


def directions(chain: FloatArray) -> tuple[FloatArray, FloatArray]:
    given = network([control([(0, 0, 0), (10, 0, 0)], "c")], [chain])
    context = LoopContext.of(given, GOOD, None)
    scene = context.scene(context.begin().state)
    found = chain_directions(scene, ChainOrder.of(scene.chain))
    return found.angle, found.sigma


def test_errors_of_directions_follow_their_sigma() -> None:
    """Dense points, where neighbours say nothing: mean square of normalised errors inside 1 +- 0.35."""
    generator, errors = np.random.default_rng(1), []
    for _ in range(60):
        angle = generator.uniform(-1.5, 1.5)
        line = np.linspace(0.0, 0.4, 81)[:, None] * [np.cos(angle), np.sin(angle)]
        found, sigma = directions(line + generator.normal(0.0, SIGMA_MM, line.shape))
        errors.append(np.sin(found[40] - angle) / sigma[40])
    assert 0.3 < np.mean(np.square(errors)) < 1.35  # sigma holds a share for bends


def test_where_an_edge_bends_the_direction_is_uncertain() -> None:
    angle = np.linspace(0.0, np.pi, 7)
    found, sigma = directions(0.5 * np.column_stack([np.cos(angle), np.sin(angle)]))
    tangent = angle + 0.5 * np.pi
    assert (np.abs(np.sin(found - tangent)) < 3.0 * sigma).all()


def test_at_a_fold_the_direction_says_nothing() -> None:
    """The axis of three points runs along the fold, about a right angle off the tangent at its end."""
    sigma = directions(np.array([[0.0, 0.0], [0.2, 0.0], [0.0, 0.03]]))[1]
    assert (3.0 * sigma > 0.5 * np.pi).all()
    straight = directions(np.array([[0.0, 0.0], [0.2, 0.0], [0.4, 0.03]]))[1]
    assert straight.max() < 0.15


def test_two_points_tell_no_direction() -> None:
    found, sigma = directions(np.array([[0.0, 0.0], [1.0, 1.0]]))
    assert np.isnan(found).all()
    assert np.isinf(sigma).all()


def test_chains_keep_their_order() -> None:
    order = ChainOrder.of(np.array([1, 0, -1, 1, 0, 0]))
    chains = [order.order[b:e].tolist() for b, e in sorted(set(zip(order.begin, order.end, strict=True)))]
    assert chains == [[1, 4, 5], [0, 3], [2]]
