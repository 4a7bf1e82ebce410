"""A given curve with two edges in the images is named; one edge with noise is not."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.matches import Matches, Reason
from splinebba_cli.core.matching.second_edges_of_given import given_with_two_edges
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State, initial_coefficients, prepare
from tests.core.matching.known_curves.one_image import ROADS, SIGMA_MM, control, network, seen

COUNT = 30
ACROSS = np.array([0.6, -0.8])  # of the first road, roughly, in the image


def told(shift_sigma: float, reason: Reason = Reason.MATCHED) -> tuple[Problem, ...]:
    """Six chains one behind the other along a road, three of them shifted to its side."""
    curves = [control(values, f"road-{k}") for k, values in enumerate(ROADS)]
    generator = np.random.default_rng(3)
    parts = [(0.0, 0.5), (0.1, 0.6), (0.4, 0.9), (0.0, 0.4), (0.3, 0.8), (0.5, 1.0)]
    chains = [
        seen(curves[0], COUNT, *part)
        + generator.normal(0.0, SIGMA_MM, (COUNT, 2))
        + (k % 2) * shift_sigma * SIGMA_MM * ACROSS
        for k, part in enumerate(parts)
    ]
    given = network(curves, chains)
    count = len(given.unlabelled)
    images = given.images
    state = State(
        images.rotation, images.position, initial_coefficients(prepare(given)), np.zeros((0, 3)), np.zeros(0)
    )
    reasons = np.where(given.unlabelled.chain % 2 == 1, int(reason), int(Reason.MATCHED))
    curve = np.where(reasons == int(Reason.MATCHED), 0, -1)
    none = np.full(count, np.nan)
    return given_with_two_edges(given, state, Matches(curve, none, none, none, reasons))


def test_one_edge_is_not_named() -> None:
    assert told(0.0) == ()


@pytest.mark.parametrize("reason", [Reason.MATCHED, Reason.GROSS, Reason.TAKEN])
def test_two_edges_are_named(reason: Reason) -> None:
    (problem,) = told(9.0, reason)
    assert problem.code == "SBB598"
    assert problem.subject == "spline `road-0`"
    assert "3 chains" in problem.message


def test_points_of_no_curve_do_not_count() -> None:
    assert told(9.0, Reason.FAR) == ()
