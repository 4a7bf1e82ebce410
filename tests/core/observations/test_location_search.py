"""The search for foot points: what is left out of it would not have found anything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core import speed
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    Network,
    PointObservations,
    Points,
)
from splinebba_cli.core.observations import location_search
from splinebba_cli.core.observations.location_search import search_locations, squared_distance
from splinebba_cli.core.observations.locations import location_bounds, refine_locations
from splinebba_cli.core.observations.nearby_segments import nearby_segments
from splinebba_cli.core.observations.nearest_branch import surely_nearest
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

HEIGHT = 500.0
NONE = np.zeros(0, dtype=np.int64)


def network_of(curves: list[FloatArray], points: int, spread_mm: float, seed: int) -> tuple[Prepared, State]:
    """Three vertical images over curves, points at random places of each of them, displaced by `spread_mm`."""
    generator = np.random.default_rng(seed)
    count = 3
    position = np.stack([np.linspace(-100.0, 100.0, count), np.zeros(count), np.full(count, HEIGHT)], axis=1)
    images = Images(
        ids=tuple("abc"),
        camera=np.zeros(count, dtype=np.int64),
        rotation=np.tile(np.eye(3), (count, 1, 1)),
        position=position,
        sequence=("omega-phi-kappa",) * count,
        prior=np.full((count, 6), np.nan),
        prior_sigma=np.full((count, 6), np.inf),
    )
    features = tuple(
        Curve(str(k), "tie", "natural_cubic", knots, np.full(knots.shape, np.inf))
        for k, knots in enumerate(curves)
    )
    image, curve = (np.tile(np.repeat(np.arange(n), points), m) for n, m in ((count, len(curves)), (1, 1)))
    curve = np.repeat(np.arange(len(curves)), count * points)
    seen = CurveObservations(
        image=image, curve=curve, photo_xy=np.zeros((len(image), 2)), sigma=np.full((len(image), 2), 0.005),
        location=np.full(len(image), np.nan), segment=np.full(len(image), -1),
    )  # fmt: skip
    network = Network(
        origin=np.zeros(3),
        cameras=(Camera("c", 100.0, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2)),),
        images=images,
        points=Points((), (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))),
        curves=features,
        point_observations=PointObservations(NONE, NONE, np.zeros((0, 2)), np.zeros((0, 2))),
        curve_observations=seen,
    )
    prepared = prepare(network)
    coefficients = initial_coefficients(prepared)
    curves_of = prepared.curves
    location = generator.uniform(curves_of.first[curve], curves_of.last[curve])
    xyz = curves_of.evaluate(coefficients, curve, location)[0]
    off = xyz - position[image]
    xy = -100.0 * off[:, :2] / off[:, 2:] + generator.normal(0.0, spread_mm, (len(image), 2))
    prepared = prepare(replace(network, curve_observations=replace(seen, photo_xy=xy)))
    return prepared, State(images.rotation, position, coefficients, np.zeros((0, 3)), location)


def winding(turns: int, seed: int) -> FloatArray:
    """Knots of a road with hairpins whose branches run close to each other."""
    generator = np.random.default_rng(seed)
    x = np.where(np.arange(2 * turns) // 1 % 2 == 0, -40.0, 40.0) + generator.normal(0.0, 8.0, 2 * turns)
    y = np.linspace(-60.0, 60.0, 2 * turns) + generator.normal(0.0, 2.0, 2 * turns)
    return np.stack([x, y, generator.normal(0.0, 5.0, 2 * turns)], axis=1)


def smooth(seed: int) -> FloatArray:
    generator = np.random.default_rng(seed)
    heading = np.cumsum(generator.normal(0.0, 0.3, 6))
    step = 25.0 * np.stack([np.cos(heading), np.sin(heading), 0.1 * np.sin(3.0 * heading)], axis=1)
    return np.cumsum(step, axis=0) - 60.0


@pytest.mark.parametrize("spread_mm", [0.005, 0.5, 3.0, 25.0])  # radii of curvature are some 15 mm
@pytest.mark.parametrize("seed", range(3))
def test_sure_points_are_nearest(spread_mm: float, seed: int) -> None:
    """No sample of the curve, some 300 a segment, is nearer than a foot point that is called certain."""
    prepared, state = network_of([winding(3, seed), smooth(seed), winding(2, 9 + seed)], 30, spread_mm, seed)
    generator = np.random.default_rng(50 + seed)
    moved = state.location + generator.normal(0.0, 0.3, len(state.location))  # some end at other branches
    near = refine_locations(prepared, replace(state, location=moved))
    sure = surely_nearest(prepared, near)
    distance = squared_distance(prepared, near)
    for k in np.flatnonzero(sure):
        curve = prepared.network.curve_observations.curve[k]
        low, high = prepared.curves.first[curve], prepared.curves.last[curve]
        u = np.linspace(low, high, 2000)
        least = least_on_samples(prepared, near, int(k), u)
        assert distance[k] <= least * (1.0 + 1e-9) + 1e-9
    if spread_mm < 0.1:
        of_smooth = prepared.network.curve_observations.curve == 1
        assert sure[of_smooth].mean() > 0.7  # most of them are spared the search


def least_on_samples(prepared: Prepared, state: State, k: int, u: FloatArray) -> float:
    seen = prepared.network.curve_observations
    xyz = prepared.curves.evaluate(state.coefficients, np.full(len(u), seen.curve[k]), u)[0]
    off = xyz - state.position[seen.image[k]]
    xy = -100.0 * off[:, :2] / off[:, 2:]
    return float(np.min(np.sum(((xy - seen.photo_xy[k]) / seen.sigma[k]) ** 2, axis=1)))


@pytest.mark.parametrize("mode", ["never", "always"])
def test_the_search_finds_what_sampling_everything_finds(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if mode == "always":
        pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, mode)
    prepared, state = network_of([winding(4, 3), smooth(4)], 80, 0.005, 7)
    wrong = replace(state, location=np.full(len(state.location), 0.3))
    searched = search_locations(prepared, wrong)
    monkeypatch.setattr(
        location_search, "surely_nearest", lambda _, at: np.zeros(len(at.location), dtype=bool)
    )
    everywhere = search_locations(prepared, replace(state, location=state.location * np.nan))
    np.testing.assert_allclose(
        squared_distance(prepared, searched), squared_distance(prepared, everywhere), rtol=1e-6, atol=1e-6
    )


def test_of_a_long_curve_only_what_is_near_is_sampled() -> None:
    """1 200 knots along 30 km, three images that see some 300 m of it: found, with few candidates."""
    along = np.arange(1200) * 25.0 - 15_000.0
    coast = np.stack([along, 20.0 * np.sin(along / 60.0), 5.0 * np.cos(along / 90.0)], axis=1)
    prepared, state = network_of([coast], 1, 0.0, 1)
    seen = prepared.network.curve_observations
    u = np.linspace(590.0, 606.0, 40)
    image = np.repeat(np.arange(3), len(u))
    only = np.zeros(len(image), dtype=np.int64)
    xyz = prepared.curves.evaluate(state.coefficients, only, prepared_u(prepared, image, u))[0]
    off = xyz - state.position[image]
    xy = -100.0 * off[:, :2] / off[:, 2:]
    none = np.full(len(image), -1)
    observed = replace(
        seen, image=image, curve=only, photo_xy=xy,
        sigma=np.full((len(image), 2), 0.005), location=np.full(len(image), np.nan), segment=none,
    )  # fmt: skip
    prepared = prepare(replace(prepared.network, curve_observations=observed))
    state = replace(state, location=np.full(len(image), np.nan))
    found = search_locations(prepared, state)
    expected = prepared_u(prepared, image, u)
    speed_of = prepared.curves.length.mean()
    np.testing.assert_allclose(found.location, expected, atol=1e-7 * speed_of)
    centre = np.stack([xy[image == k].mean(axis=0) for k in range(3)])
    radius = np.array([np.linalg.norm(xy[image == k] - centre[k], axis=1).max() for k in range(3)])
    segments = nearby_segments(
        prepared, state, prepared.curves.segment_polynomials(state.coefficients), np.arange(3),
        np.zeros(3, dtype=np.int64), centre, radius,
    )  # fmt: skip
    assert 16 <= segments.shape[1] <= 120
    low, _ = location_bounds(prepared)
    assert np.isfinite(low).all()


def prepared_u(prepared: Prepared, image: np.ndarray, u: FloatArray) -> FloatArray:
    """Parameters of the knot numbers u, one set for every image."""
    breaks = prepared.curves.bases[0].break_points
    return np.tile(np.interp(u, np.arange(len(breaks)), breaks), int(image.max()) + 1)


def test_the_search_goes_by_sigma_and_not_by_millimetres() -> None:
    """Error ellipses of 1 : 20: never worse in sigma than the search that begins from nothing."""
    prepared, state = network_of([winding(3, 5), smooth(6)], 40, 0.3, 11)
    seen = prepared.network.curve_observations
    sigma = np.tile([0.005, 0.1], (len(seen), 1))
    prepared = prepare(replace(prepared.network, curve_observations=replace(seen, sigma=sigma)))
    assert prepared.rays_by_component.axis_ratio == pytest.approx(20.0)
    assert not surely_nearest(prepared, refine_locations(prepared, state)).any()
    moved = state.location + np.random.default_rng(12).normal(0.0, 0.3, len(state.location))
    found = squared_distance(prepared, search_locations(prepared, replace(state, location=moved)))
    everywhere = search_locations(prepared, replace(state, location=moved * np.nan))
    assert (found <= squared_distance(prepared, everywhere) * (1.0 + 1e-6) + 1e-6).all()
