"""Orientation from unlabelled chains: found with wrong chains among them, refused where it is not to be told."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from benchmarks.free_orientation_scenes import (
    FreeScene,
    free_scene,
    orientation_errors,
    without_orientations,
    wrong_chains,
)
from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.matching.free_orientation import search
from splinebba_cli.core.matching.free_orientation.chain_raster import ChainRaster
from splinebba_cli.core.matching.free_orientation.chains import image_chains
from splinebba_cli.core.matching.free_orientation.orient_freely import orient_freely
from splinebba_cli.core.matching.free_orientation.places import CurveSamples, KnownCurves
from splinebba_cli.core.matching.free_orientation.prior import PriorFilter
from splinebba_cli.core.matching.free_orientation.refinement import Refiner
from splinebba_cli.core.matching.free_orientation.rough_refinement import roughly_refined
from splinebba_cli.core.matching.free_orientation.score import CoarseScore
from splinebba_cli.core.matching.free_orientation.seen import Seen, across_design, apart, see
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import (
    Camera,
    Curve,
    FloatArray,
    PointObservations,
    Points,
    UnlabelledPoints,
    select_rows,
)
from splinebba_cli.core.state import prepare

C = 15.0
SIGMA = 0.0025  # mm, half a pixel of 5 um
CAMERA = Camera("c", C, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2), 0.005, (12.0, 9.0))


def looking_at(position: FloatArray, at: FloatArray, roll: float) -> FloatArray:
    """A rotation (object from photo) that looks from a place to another one."""
    back = (position - at) / np.linalg.norm(position - at)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    turn = rotation_from_vector(np.array([0.0, 0.0, roll]))
    return np.column_stack([right, np.cross(back, right), back]) @ turn


def edges(seed: int, count: int = 7) -> tuple[Curve, ...]:
    """Fixed natural splines of five knots inside a metre."""
    rng = np.random.default_rng(seed)
    curves = []
    for k in range(count):
        start, way = rng.uniform(-0.4, 0.4, 3), rng.normal(0.0, 0.35, 3)
        knots = start + np.linspace(-0.5, 0.5, 5)[:, None] * way + rng.normal(0.0, 0.06, (5, 3))
        curves.append(Curve(f"edge-{k}", "control", "natural_cubic", knots, np.zeros((5, 3))))
    return tuple(curves)


def cube() -> tuple[Curve, ...]:
    """The twelve edges of a cube: 24 orientations see the same."""
    corners = np.array(list(product((-0.3, 0.3), repeat=3)))
    pairs = [(a, b) for a in range(8) for b in range(a) if np.count_nonzero(corners[a] - corners[b]) == 1]
    return tuple(
        Curve(f"{a}-{b}", "control", "straight_line", corners[[a, b]], np.zeros((2, 3))) for a, b in pairs
    )


def known_curves_of(curves: tuple[Curve, ...]) -> KnownCurves:
    return KnownCurves(prepare(without_orientations(CAMERA, curves, 1, UnlabelledPoints.none())))


def scene(
    curves: tuple[Curve, ...], images: int, seed: int, wrong: float = 0.3, cut: bool = False
) -> FreeScene:
    """Views from around, all curves traced, wrong chains among them."""
    rng = np.random.default_rng(seed)
    azimuth = 2.0 * np.pi * (np.arange(images) + rng.uniform(0.1, 0.4)) / images
    position = 1.6 * np.column_stack([np.cos(azimuth), np.sin(azimuth), 0.5 + 0.2 * np.sin(2.0 * azimuth)])
    rotation = np.array([looking_at(x, np.zeros(3), rng.uniform(-3.0, 3.0)) for x in position])
    samples = known_curves_of(curves).samples(900)
    chains: list[tuple[int, int, FloatArray]] = []
    count = len(samples.curve)
    for image in range(images):
        turn, place = np.tile(rotation[image], (count, 1, 1)), np.tile(position[image], (count, 1))
        xy = project(np.full(count, C), turn, place, samples.xyz)
        right = [(image, k, xy[samples.curve == k]) for k in range(len(curves))]
        chains += right + [(image, -1, each) for each in wrong_chains(rng, [r[2] for r in right], wrong)]
    return free_scene(rng, CAMERA, curves, rotation, position, chains, SIGMA, cut)


def test_images_are_oriented_in_spite_of_wrong_chains() -> None:
    """A standard deviation of the position is 0.2 to 0.4 mm at 1.8 m."""
    made = scene(edges(1), 2, 2)
    found = orient_freely(made.network, MatchSettings(seed=3))
    assert found.problems == () and sorted(found.from_chains) == [0, 1]
    for image, each in found.from_chains.items():
        angle, away = orientation_errors(made, image, each.rotation, each.position)
        assert away < 4.0 * np.linalg.norm(each.sigma[3:]) < 0.01
        assert angle < 0.2
        assert 0.5 < each.explained < 0.85  # 70 % of the chains, by length less
    applied = found.apply(made.network)
    assert applied.images.has_orientation.all() and not made.network.images.has_orientation.any()


def test_chains_that_end_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "CONFIRMED", 1)
    made = scene(edges(4), 1, 6, cut=True)
    found = orient_freely(made.network, MatchSettings(seed=1))
    each = found.from_chains[0]
    assert orientation_errors(made, 0, each.rotation, each.position)[1] < 0.01


def test_same_seed_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "CONFIRMED", 1)
    network = scene(edges(6), 1, 7).network
    first, second = (orient_freely(network, MatchSettings(seed=5)).from_chains[0] for _ in range(2))
    np.testing.assert_array_equal(first.rotation, second.rotation)
    np.testing.assert_array_equal(first.position, second.position)


def test_a_symmetric_object_is_not_oriented(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "GIVEN_UP", 1)
    (problem,) = orient_freely(scene(cube(), 1, 8, wrong=0.0).network).problems
    assert problem.code == "SBB589"
    assert problem.subject == "image `0`"


def test_a_prior_chooses_between_symmetric_orientations() -> None:
    made = scene(cube(), 1, 8, wrong=0.0)
    images = made.network.images
    prior, sigma = images.prior.copy(), images.prior_sigma.copy()
    prior[0, 3:], sigma[0, 3:] = made.position[0] + 0.05, 0.05
    network = replace(made.network, images=replace(images, prior=prior, prior_sigma=sigma))
    found = orient_freely(network)
    # turns about the diagonals and axes move the camera; none leaves it where the prior has it
    assert orientation_errors(made, 0, found.from_chains[0].rotation, found.from_chains[0].position)[1] < 0.01


def test_chains_of_other_edges_are_not_taken_for_known_curves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "BATCHES", 1)
    monkeypatch.setattr(search, "PAIRS_IN_BATCH", 2)
    made = scene(edges(9), 1, 10)
    rows = np.flatnonzero(made.label < 0)
    network = replace(made.network, unlabelled=select_rows(made.network.unlabelled, rows))
    found = orient_freely(network)
    assert found.from_chains == {}
    assert found.problems[0].code in ("SBB588", "SBB589")


def test_nothing_to_search_from() -> None:
    made = scene(edges(11), 1, 12)
    none = select_rows(made.network.unlabelled, np.zeros(0, dtype=np.int64))
    (no_chains,) = orient_freely(replace(made.network, unlabelled=none)).problems
    free = tuple(replace(curve, role="tie", sigma=np.full((5, 3), np.inf)) for curve in made.network.curves)
    (no_curves,) = orient_freely(replace(made.network, curves=free)).problems
    assert (no_chains.code, no_curves.code) == ("SBB587", "SBB587")
    assert "chains" in no_chains.message and "known shape" in no_curves.message


def test_chains_that_lead_nowhere_are_none() -> None:
    made = scene(edges(11), 1, 12).network
    points = made.unlabelled
    still = replace(made, unlabelled=replace(points, photo_xy=np.tile([1.0, 2.0], (len(points), 1))))
    assert image_chains(still, 0) is None
    assert orient_freely(still).problems[0].code == "SBB587"
    some = np.where((points.chain == points.chain[0])[:, None], [1.0, 2.0], points.photo_xy)
    chains = image_chains(replace(made, unlabelled=replace(points, photo_xy=some)), 0)
    assert chains is not None and points.chain[0] not in chains.chain and (chains.length > 0.0).all()


def test_the_picture_holds_chains_that_distortion_moves_beyond_the_format() -> None:
    made = scene(edges(11), 1, 12).network
    small = replace(made, cameras=(replace(CAMERA, format_mm=(2.0, 2.0)),))
    chains = image_chains(small, 0)
    assert chains is not None
    np.testing.assert_array_equal(chains.format_mm, [chains.xy.min(axis=0), chains.xy.max(axis=0)])


def test_images_follow_through_points() -> None:
    """Two images have chains; the third one sees points that these intersect."""
    made = scene(edges(13), 3, 14)
    rng = np.random.default_rng(15)
    xyz = rng.uniform(-0.3, 0.3, (12, 3))
    image, point = np.repeat(np.arange(3), 12), np.tile(np.arange(12), 3)
    xy = project(np.full(36, C), made.rotation[image], made.position[image], xyz[point])
    free = np.full((12, 3), np.inf)
    points = Points(
        tuple(map(str, range(12))), ("tie",) * 12, np.full((12, 3), np.nan), free, np.full((12, 3), np.nan)
    )
    observed = PointObservations(image, point, xy, np.full((36, 2), SIGMA))
    chains = select_rows(made.network.unlabelled, np.flatnonzero(made.network.unlabelled.image < 2))
    found = orient_freely(
        replace(made.network, points=points, point_observations=observed, unlabelled=chains)
    )
    assert found.problems == () and sorted(found.from_chains) == [0, 1] and sorted(found.from_points) == [2]
    assert orientation_errors(made, 2, found.from_points[2].rotation, found.from_points[2].position)[1] < 0.01


@pytest.fixture(scope="module")
def one() -> tuple[FreeScene, KnownCurves]:
    made = scene(edges(16), 1, 17)
    return made, KnownCurves(prepare(made.network))


def test_score_prefers_the_truth_to_cameras_that_shrink_or_cover(one: tuple[FreeScene, KnownCurves]) -> None:
    made, known = one
    chains = image_chains(made.network, 0)
    assert chains is not None
    raster = ChainRaster(chains, 0.1, 0.35)
    score = CoarseScore(chains, known.samples(300), raster, 0.05)
    rotation, position = (
        made.rotation[[0] * 4],
        made.position[[0] * 4] * np.array([[1.0], [40.0], [0.4], [-1.0]]),
    )
    truth, far, near, behind = score(rotation, position)
    assert truth > 0.6
    assert max(far, near) < 0.5 * truth
    assert behind == 0.0
    others = known_curves_of((*made.network.curves, *edges(18, 20)))
    covered = CoarseScore(chains, others.samples(1200), raster, 0.05)(made.rotation[:1], made.position[:1])[0]
    assert covered < 0.75 * truth  # curves that the image does not show speak against an orientation


def test_refinement_returns_from_some_degrees(one: tuple[FreeScene, KnownCurves]) -> None:
    made, known = one
    chains = image_chains(made.network, 0)
    assert chains is not None
    refiner = Refiner(chains, known.samples(2000), 0.35, 400)
    turned = made.rotation[0] @ rotation_from_vector(np.radians([0.3, -0.3, 0.5]))
    moved = made.position[0] + made.rotation[0] @ np.array([0.004, 0.004, -0.01])
    fitted = refiner.refine(turned, moved, 0.2)
    assert fitted is not None
    fitted = refiner.polish(fitted)
    assert orientation_errors(made, 0, fitted.rotation, fitted.position)[1] < 4.0 * np.linalg.norm(
        fitted.sigma[3:]
    )
    assert fitted.rms_mm == pytest.approx(SIGMA, rel=0.15)


def test_rough_refinement_brings_many_near_and_gives_up_others(one: tuple[FreeScene, KnownCurves]) -> None:
    """From places up to half a gate off to less than the cells of the raster; a camera that sees nothing is none."""
    made, known = one
    chains = image_chains(made.network, 0)
    assert chains is not None
    g = np.random.default_rng(19)
    turned = made.rotation[0] @ rotation_from_vector(g.normal(0.0, 0.002, (12, 3)))
    moved = made.position[0] + g.normal(0.0, 0.004, (12, 3))
    moved[-1] *= -1.0
    raster = ChainRaster(chains, 0.3, 0.35)
    rotation, position = roughly_refined(chains, known.samples(500), raster, turned, moved, 0.2, 0.06)
    assert np.isnan(rotation[-1]).all() and np.isnan(position[-1]).all()
    samples = known.samples(100)
    truth = see(chains, samples, made.rotation[:1], made.position[:1])
    found, before = (
        see(chains, samples, *each) for each in ((rotation[:-1], position[:-1]), (turned[:-1], moved[:-1]))
    )

    def away(other: Seen) -> FloatArray:
        return np.nanmedian(np.hypot(other.x - truth.x, other.y - truth.y), axis=1)

    assert (away(before) > 0.02).all()
    assert (away(found) < 0.2 * raster.cell).all()


def test_curves_that_cross_chains_do_not_run_along_them(one: tuple[FreeScene, KnownCurves]) -> None:
    made, known = one
    chains = image_chains(made.network, 0)
    assert chains is not None
    raster, samples = ChainRaster(chains, 0.1, 0.35), known.samples(300)
    back = made.rotation[0, :, 2]
    turned = replace(samples, tangent=np.cross(back, samples.tangent))  # by a right angle in the picture
    along, across = (
        raster.beside(see(chains, each, made.rotation[:1], made.position[:1]), np.full(1, 0.05)).hit.mean()
        for each in (samples, turned)
    )
    assert along > 0.9 and across < 0.1


def test_orientations_are_told_apart_by_what_the_picture_shows(one: tuple[FreeScene, KnownCurves]) -> None:
    """Most places lie behind all of these cameras, and far beside the picture small turns grow large."""
    chains = image_chains(one[0].network, 0)
    assert chains is not None
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = 5.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.02 * np.cos(2.0 * angle)])
    samples = CurveSamples(ring, ring, np.zeros(40, dtype=np.int64), angle, np.ones(40))
    to = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    rotation = np.array([looking_at(np.zeros(3), each, 0.0) for each in to])
    rotation = np.concatenate([rotation, rotation[:1] @ rotation_from_vector(np.array([0.0, 1e-4, 0.0]))])
    seen = see(chains, samples, rotation, np.zeros((4, 3)))
    assert (np.isnan(seen.x).mean(axis=1) > 0.45).all() and (seen.inside.sum(axis=1) >= 3).all()
    away = apart(seen, 0)
    assert away[0] == 0.0 and (away[1:3] > 5.0).all()
    assert away[3] == pytest.approx(1e-4 * C, rel=0.2)


def test_derivatives_of_distances_across(one: tuple[FreeScene, KnownCurves]) -> None:
    made, known = one
    xyz, rotation, position = known.samples(50).xyz, made.rotation[0], made.position[0]
    normal = np.tile([0.6, 0.8], (50, 1))
    design = across_design(C, (xyz - position) @ rotation, normal, rotation)
    each = across_design(C, (xyz - position) @ rotation, normal, np.tile(rotation, (50, 1, 1)))
    np.testing.assert_allclose(each, design, rtol=1e-14)
    h = 1e-30j
    for column in range(6):
        step = np.zeros(6, dtype=complex)
        step[column] = h
        a, b, c = step[:3]
        cross = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
        p = (xyz - position - step[3:]) @ rotation @ (np.eye(3) + cross)
        xy = -C * p[:, :2] / p[:, 2:]
        np.testing.assert_allclose(
            design[:, column], np.sum(xy * normal, axis=1).imag / 1e-30, rtol=1e-12, atol=1e-12
        )


def test_prior_keeps_what_agrees_with_it() -> None:
    prior = np.array([np.nan, np.nan, np.pi - 0.01, np.nan, np.nan, 500.0])
    sigma = np.array([np.inf, np.inf, 0.01, np.inf, np.inf, 10.0])
    keeps = PriorFilter(prior, sigma, "omega-phi-kappa")
    kappa = np.array([np.pi - 0.02, -np.pi + 0.02, 0.0, np.pi])
    rotation = np.array([rotation_from_vector(np.array([0.0, 0.0, angle])) for angle in kappa])
    position = np.array([[0.0, 0.0, 520.0], [9.0, 9.0, 460.0], [0.0, 0.0, 500.0], [0.0, 0.0, 560.0]])
    assert keeps(rotation, position).tolist() == [True, True, False, False]
