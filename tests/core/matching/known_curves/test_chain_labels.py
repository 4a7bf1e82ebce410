"""Labels of chains at a known orientation: splitting, leaving, crossing, twins, ambiguity, exclusion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.matching.matches import Reason
from splinebba_cli.core.matching.settings import MatchSettings
from tests.core.matching.known_curves.one_image import SIGMA_MM, control, labelled, network, seen

EAST = control([(-100, 0, 0), (0, 0, 0)], "east")
NORTH = control([(0, 0, 0), (0, 100, 0)], "north")
CROSSING = control([(-50, -50, 0), (-50, 50, 0)], "crossing")


def noise(count: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, SIGMA_MM, (count, 2))


def test_a_chain_over_two_curves_is_split_at_the_corner() -> None:
    chain = np.vstack([seen(EAST, 30, 0.3, 0.98), seen(NORTH, 30, 0.02, 0.7)]) + noise(60)
    curve = labelled(network([EAST, NORTH], [chain])).matches.curve
    assert (curve[:28] == 0).all()
    assert (curve[32:] == 1).all()


def test_a_chain_that_leaves_its_curve_is_matched_while_it_follows() -> None:
    away = seen(EAST, 30, 0.5, 1.0)
    away[:, 1] += np.linspace(0.05, 6.0, 30)
    chain = np.vstack([seen(EAST, 30, 0.0, 0.5), away]) + noise(60)
    found = labelled(network([EAST], [chain])).matches
    assert (found.curve[:30] == 0).all()
    assert (found.curve[35:] == -1).all()


@pytest.mark.parametrize("degrees", [20.0, 45.0, 90.0])
def test_a_chain_that_crosses_a_curve_is_not_matched(degrees: float) -> None:
    middle, reach = seen(EAST, 3)[1], np.linspace(-1.0, 1.0, 400)[:, None]
    chain = middle + reach * [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))] + noise(400)
    found = labelled(network([EAST], [chain])).matches
    assert (found.curve == -1).all()
    assert set(found.reason) <= {Reason.FAR, Reason.DIRECTION, Reason.CHAIN}
    assert set(found.reason) - {Reason.FAR}


@pytest.mark.parametrize(("degrees", "reason"), [(0.0, Reason.MATCHED), (70.0, Reason.DIRECTION)])
def test_single_points_with_directions(degrees: float, reason: Reason) -> None:
    xy = seen(EAST, 20, 0.1, 0.9) + noise(20)
    along = np.arctan2(*(xy[-1] - xy[0])[::-1])
    given = network([EAST], [], xy)
    directed = replace(given.unlabelled, direction=np.full(20, along + np.radians(degrees)))
    found = labelled(replace(given, unlabelled=directed)).matches
    assert (found.reason == reason).all()


@pytest.mark.parametrize(("height", "count"), [(20.0, 3), (8.0, 4), (8.0, 5), (2.0, 3)])
def test_few_points_around_a_circle_keep_to_it(height: float, count: int) -> None:
    """Chords turn by 72 degrees and more from point to point, and fold where the circle is an ellipse."""
    values = np.array([[3000.0, 4000.0, 0.0], [20.0, 0.0, 0.0], [0.0, height, 0.0]])
    circle = replace(EAST, id="round", family="conic", values=values, sigma=np.zeros((3, 3)))
    chain = seen(circle, count, 0.05, 0.95) + noise(count)
    assert (labelled(network([circle], [chain])).matches.curve == 0).all()


def test_single_points_at_a_crossing_are_ambiguous_and_a_chain_resolves_them() -> None:
    xy = seen(EAST, 41, 0.4, 0.6) + noise(41)
    here = np.array([20])  # where `crossing` passes
    alone = labelled(network([EAST, CROSSING], [], xy)).matches
    chain = labelled(network([EAST, CROSSING], [xy])).matches
    assert (alone.reason[here] == Reason.AMBIGUOUS).all()
    assert (alone.curve[[0, 40]] == 0).all()
    assert (chain.curve == 0).all()
    assert np.isfinite(chain.runner_up[here]).all()


def test_between_two_lines_that_fit_equally_well_nothing_is_chosen() -> None:
    near, far = (control([(-100, y, 0), (0, y, 0)], str(y)) for y in (-0.02, 0.02))
    chain = seen(EAST, 30) + noise(30)
    found = labelled(network([near, far], [chain])).matches
    assert (found.reason == Reason.AMBIGUOUS).all()
    assert (found.curve == -1).all()


def test_of_two_chains_on_one_stretch_the_better_one_keeps_it() -> None:
    right, other = seen(EAST, 30) + noise(30), seen(EAST, 30) + noise(30, 2) + [0.0, 0.1]
    rough = MatchSettings(position_sigma_m=0.5, angle_sigma_rad=1e-4)
    found = labelled(network([EAST], [right, other]), rough).matches
    assert (found.curve[:30] == 0).all()
    assert (found.reason[30:] == Reason.TAKEN).all()


def test_an_edge_may_be_traced_twice() -> None:
    chains = [seen(EAST, 30) + noise(30), seen(EAST, 20, 0.2, 0.8) + noise(20, 2)]
    rough = MatchSettings(position_sigma_m=0.5, angle_sigma_rad=1e-4)
    assert (labelled(network([EAST], chains), rough).matches.curve == 0).all()


def test_beyond_the_end_of_a_curve_there_is_no_label() -> None:
    beyond = seen(EAST, 2)[1] + np.linspace(0.2, 2.0, 20)[:, None] * [1.0, 0.0]
    found = labelled(network([EAST], [np.vstack([seen(EAST, 30), beyond])])).matches
    assert (found.curve[:30] == 0).all()
    assert (found.curve[30:] == -1).all()
