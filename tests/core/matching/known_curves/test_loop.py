"""One image against control curves: the adjustment of the right labels, verdicts, reasons, repeatability."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contaminated import with_moved_orientations
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.matches import MatchResult, Reason
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Network, select_rows
from tests.core.matching.known_curves.one_image import BLOCK, ROADS, SIGMA_MM, control, network, seen

SETTINGS = MatchSettings(position_sigma_m=5.0, angle_sigma_rad=0.01)


def roads(seed: int = 1, position_m: float = 5.0, angle_rad: float = 0.01, points: int = 40) -> Network:
    """Two roads, traced with noise; the orientation is off by 5 m and 0.6 degrees."""
    curves = [control(values, f"road-{k}") for k, values in enumerate(ROADS)]
    generator = np.random.default_rng(seed)
    chains = [seen(curve, points) + generator.normal(0.0, SIGMA_MM, (points, 2)) for curve in curves]
    return with_moved_orientations(network(curves, chains), generator, position_m, angle_rad)


@pytest.fixture(scope="module")
def matched() -> MatchResult:
    return match(roads(), SETTINGS)


def test_all_points_find_their_curve(matched: MatchResult) -> None:
    assert np.mean(matched.matches.curve == np.repeat([0, 1], 40)) > 0.97
    assert not ((matched.matches.curve >= 0) & (matched.matches.curve != np.repeat([0, 1], 40))).any()
    assert len(matched.network.curve_observations) + len(matched.network.unlabelled) == 80


@pytest.mark.parametrize("points", [40, 600])
def test_the_orientation_is_that_of_the_adjustment_with_these_labels(points: int) -> None:
    """Points on held curves stand for them (held_feet.py): same orientation, same dispersion.

    Of many points some lose their label after the last round; the orientation is that without them.
    """
    matched = match(roads(points=points), SETTINGS)
    adjusted = adjust(matched.network)
    sigma = np.sqrt(np.einsum("mii->mi", adjusted.images.dispersion))
    assert (
        np.abs(matched.network.images.position - adjusted.images.eop[:, 3:]).max() < 0.01 * sigma[:, 3:].min()
    )
    own = np.sqrt(np.einsum("mii->mi", matched.eop_dispersion))
    np.testing.assert_allclose(own, sigma, rtol=0.02)


def test_errors_of_the_orientation_are_as_predicted(matched: MatchResult) -> None:
    sigma = np.sqrt(np.einsum("mii->mi", matched.eop_dispersion))[0, 3:]
    assert (np.abs(matched.network.images.position[0] - BLOCK.eop[0, 3:]) < 4.0 * sigma).all()
    assert matched.oriented.all()
    assert matched.problems == ()


def test_the_history_ends_without_changes(matched: MatchResult) -> None:
    last = matched.history[-1]
    assert last.changed == 0
    assert last.sigma0 == pytest.approx(1.0, abs=0.35)


def test_the_same_seed_gives_the_same_result(matched: MatchResult) -> None:
    again = match(roads(), SETTINGS)
    np.testing.assert_array_equal(again.matches.curve, matched.matches.curve)
    np.testing.assert_array_equal(again.network.images.position, matched.network.images.position)


def test_matching_a_matched_network_again_changes_nothing(matched: MatchResult) -> None:
    again = match(matched.network, SETTINGS)
    sigma = np.sqrt(np.einsum("mii->mi", matched.eop_dispersion))[:, 3:]
    moved = np.abs(again.network.images.position - matched.network.images.position)
    assert (moved < 0.02 * sigma).all()
    assert len(again.network.curve_observations) == len(matched.network.curve_observations)


def test_without_stated_errors_growing_ranges_are_searched() -> None:
    found = match(roads(), MatchSettings())
    assert np.mean(found.matches.curve == np.repeat([0, 1], 40)) > 0.97
    assert found.oriented.all()


@pytest.mark.parametrize(
    ("seed", "position_m", "angle_rad"),
    [
        (7, 40.0, 0.15),  # rounds from the prior lead nowhere, though no point has two curves in its gate
        (10, 80.0, 0.25),  # and the quick search of the prior finds nothing
    ],
)
def test_few_curves_far_off_are_found(seed: int, position_m: float, angle_rad: float) -> None:
    settings = MatchSettings(position_sigma_m=position_m, angle_sigma_rad=angle_rad)
    found = match(roads(seed, position_m, angle_rad), settings)
    assert np.mean(found.matches.curve == np.repeat([0, 1], 40)) > 0.97
    assert found.oriented.all()


@pytest.mark.parametrize(
    ("lines", "named"),
    [
        ([[(-150, -100, 10), (150, 120, 12)]], {"X₀", "Y₀"}),
        ([[(-150, y, 10), (150, y, 10)] for y in (-120, -60, 20, 100)], {"X₀"}),
    ],
)
def test_what_lines_do_not_determine_is_named_and_stays(
    lines: list[list[tuple[float, float, float]]], named: set[str]
) -> None:
    """One straight line leaves four elements, parallel ones in a plane the shift along them."""
    curves = [control(values, f"line-{k}") for k, values in enumerate(lines)]
    generator = np.random.default_rng(1)
    chains = [seen(curve, 30) + generator.normal(0.0, SIGMA_MM, (30, 2)) for curve in curves]
    given = with_moved_orientations(network(curves, chains), generator, 1.0, 0.002)
    found = match(given, MatchSettings(position_sigma_m=1.0, angle_sigma_rad=0.002))
    problem = next(each for each in found.problems if each.code == "SBB580")
    assert all(name in problem.message for name in named)
    assert "Z₀" not in problem.message
    assert not found.oriented.any()
    np.testing.assert_array_equal(found.network.images.position, given.images.position)
    assert np.mean(found.matches.curve == np.repeat(np.arange(len(lines)), 30)) > 0.9


def test_repeated_lines_are_ambiguous_and_nothing_is_guessed() -> None:
    """A grid of 8 m, seen in its middle, with an orientation that is off by more than that."""
    grid = [[(-90, d, 10), (90, d, 10)] for d in range(-80, 81, 8)]
    grid += [[(d, -90, 10), (d, 90, 10)] for d in range(-80, 81, 8)]
    curves = [control(values, f"line-{k}") for k, values in enumerate(grid)]
    chains = [seen(curve, 20, 0.35, 0.65) for curve in (*curves[8:13], *curves[29:34])]
    given = with_moved_orientations(network(curves, chains), np.random.default_rng(1), 10.0, 0.01)
    found = match(given, MatchSettings(position_sigma_m=10.0, angle_sigma_rad=0.01))
    assert [each.code for each in found.problems] == ["SBB581"]
    assert (found.matches.curve == -1).all()
    assert (found.matches.reason == Reason.AMBIGUOUS).all()
    np.testing.assert_array_equal(found.network.images.position, given.images.position)


def test_reasons_of_points_that_take_no_part() -> None:
    given = roads()
    excluded = np.arange(80) < 5
    found = match(replace(given, unlabelled=replace(given.unlabelled, excluded=excluded)), SETTINGS)
    assert (found.matches.reason[:5] == Reason.EXCLUDED).all()
    assert (found.matches.curve[:5] == -1).all()
    lost = replace(given.images, rotation=np.full((1, 3, 3), np.nan), position=np.full((1, 3), np.nan))
    found = match(replace(given, images=lost), replace(SETTINGS, orient_freely=False))
    assert (found.matches.reason == Reason.NOT_ORIENTED).all()
    assert np.isnan(found.network.images.position).all()


def test_chains_go_on_where_points_are_taken_out() -> None:
    given, excluded = roads(), np.arange(80) % 2 == 1
    rest = select_rows(given.unlabelled, np.flatnonzero(~excluded))
    without = match(replace(given, unlabelled=rest), SETTINGS)
    found = match(replace(given, unlabelled=replace(given.unlabelled, excluded=excluded)), SETTINGS)
    assert (found.matches.curve[excluded] == -1).all()
    np.testing.assert_array_equal(found.matches.curve[~excluded], without.matches.curve)
    assert np.mean(without.matches.curve >= 0) > 0.9


def test_a_curve_of_unknown_shape_in_one_image_gets_no_points() -> None:
    """Nothing would determine it; the adjustment would refuse the network."""
    curves = [control(values, f"road-{k}") for k, values in enumerate(ROADS)]
    free = control([(-120, -140, 10), (-60, -120, 12), (20, -130, 8)], "path")
    free = replace(free, role="tie", sigma=np.full_like(free.values, np.inf))
    chains = [seen(curve, 40) for curve in (*curves, free)]
    found = match(
        network([*curves, free], chains), MatchSettings(position_sigma_m=0.5, angle_sigma_rad=0.001)
    )
    assert (found.matches.curve[:80] >= 0).mean() > 0.95
    assert (found.matches.curve[80:] == -1).all()
    assert (found.matches.reason[80:] == Reason.ONE_IMAGE).mean() > 0.95


def test_an_image_of_something_else_is_told() -> None:
    curves = [control(values, f"road-{k}") for k, values in enumerate(ROADS)]
    generator = np.random.default_rng(1)
    chains = [
        generator.uniform(-90.0, 90.0, 2)
        + np.linspace(0.0, 8.0, 20)[:, None] * [np.cos(a), np.sin(a)]
        + np.linspace(-1.0, 1.0, 20)[:, None] ** 2 * [np.sin(a), -np.cos(a)]
        for a in generator.uniform(0.0, np.pi, 12)
    ]
    found = match(network(curves, chains), SETTINGS)
    assert {each.code for each in found.problems} & {"SBB582", "SBB584"}
    assert not found.oriented.any()


def test_an_image_with_labels_whose_other_points_follow_nothing_is_not_called_wrong(
    matched: MatchResult,
) -> None:
    """As when a matched project is matched again: what is left are the chains that belong to nothing."""
    points = matched.given.unlabelled
    away = replace(points, photo_xy=points.photo_xy[:, ::-1] + [20.0, 40.0], chain=np.full(len(points), -1))
    left = replace(matched.network, unlabelled=away)
    found = match(left, SETTINGS)
    assert (found.matches.curve < 0).mean() > 0.9
    nobody = replace(left, curve_observations=matched.given.curve_observations)
    assert "SBB582" not in {each.code for each in found.problems}
    assert {each.code for each in match(nobody, SETTINGS).problems} & {"SBB582", "SBB584"}


def test_nothing_to_match() -> None:
    curves = [control(ROADS[0], "road")]
    assert len(match(network(curves, [])).matches.curve) == 0
    alone = match(network([], [np.zeros((5, 2))]))
    assert (alone.matches.curve == -1).all()
