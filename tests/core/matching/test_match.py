"""The whole way of a matching: usual and unusual networks, what stays as given, what is said of every point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.matches import MatchResult, Reason
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Curve, Network, UnlabelledPoints, select_rows
from tests.core.matching.fragments.small_scenes import arc, scene, straight
from tests.core.matching.scenes import curve

KNOWN = MatchSettings(position_sigma_m=0.5, angle_sigma_rad=5e-4)
NEW = replace(KNOWN, new_curves=True)


@pytest.fixture(scope="module")
def street() -> Network:
    """Three control splines in four images, 1 000 m high; all chains show one of them."""
    block = scene([arc(60.0, 2.5), straight((-120.0, 70.0, 0.0), (1.0, -0.4, 0.05)),
                   straight((0.0, -90.0, 20.0), (1.0, 1.5, 0.0))])  # fmt: skip
    every = np.linspace(0, block.curves.shape[1] - 1, 25).round().astype(int)
    curves = tuple(curve("natural_cubic", each[every]) for each in block.curves)
    return replace(block.network, curves=curves)


def with_rows(network: Network, rows: object) -> Network:
    return replace(network, unlabelled=select_rows(network.unlabelled, np.asarray(rows, dtype=np.int64)))


def only(points: UnlabelledPoints, **new: object) -> UnlabelledPoints:
    return replace(points, **new)  # type: ignore[arg-type]


def assert_complete(network: Network, found: MatchResult) -> None:
    """Every point has a curve and a place, or a reason; and is found again in the labelled network."""
    matches, labelled = found.matches, found.matches.curve >= 0
    assert len(matches.curve) == len(network.unlabelled)
    np.testing.assert_array_equal(labelled, matches.reason == Reason.MATCHED)
    np.testing.assert_array_equal(labelled, np.isfinite(matches.location))
    assert len(found.network.curve_observations) == labelled.sum()
    assert len(found.network.unlabelled) == (~labelled).sum()


def test_points_on_known_curves(street: Network) -> None:
    found = match(street, KNOWN)
    assert_complete(street, found)
    assert (found.matches.curve >= 0).mean() > 0.98
    assert not found.oriented.any()  # three curves leave some directions open: they say nothing of the images
    assert {problem.code for problem in found.problems} == {"SBB580"}


def test_dispersions_are_those_of_the_adjustment_of_the_labels() -> None:
    generator = np.random.default_rng(3)
    starts = generator.uniform([-100.0, -80.0, 0.0], [40.0, 40.0, 200.0], (14, 3))
    ways = generator.normal(size=(14, 3)) * [1.0, 1.0, 0.2]
    block = scene([straight(tuple(a), tuple(b)) for a, b in zip(starts, ways, strict=True)])
    curves = tuple(curve("straight_line", each[[0, -1]]) for each in block.curves)
    found = match(replace(block.network, curves=curves), KNOWN)
    assert found.oriented.all() and found.problems == ()
    np.testing.assert_allclose(
        found.eop_dispersion, adjust(found.network).images.dispersion, rtol=1e-6, atol=1e-15
    )


def test_fixed_curves_keep_their_values_free_ones_get_better_ones(street: Network) -> None:
    tie = street.curves[1]
    off = tie.values + np.array([0.0, 0.3, 0.0])
    free = replace(tie, role="tie", sigma=np.full(tie.sigma.shape, np.inf), values=off)
    found = match(replace(street, curves=(street.curves[0], free, street.curves[2])), KNOWN)
    np.testing.assert_array_equal(found.network.curves[0].values, street.curves[0].values)
    improved = found.network.curves[1]
    assert np.abs(improved.values - off).max() > 0.1
    assert improved.reference is not None
    np.testing.assert_array_equal(improved.reference, off)


SOME: dict[str, Callable[[Network], Network]] = {
    "no points": lambda n: with_rows(n, []),
    "one point": lambda n: with_rows(n, [5]),
    "one chain": lambda n: with_rows(n, np.flatnonzero(n.unlabelled.chain == 0)),
    "one image": lambda n: with_rows(n, np.flatnonzero(n.unlabelled.image == 1)),
    "one image, no curves": lambda n: replace(
        with_rows(n, np.flatnonzero(n.unlabelled.image == 1)), curves=()
    ),
    "single points": lambda n: replace(
        n, unlabelled=only(n.unlabelled, chain=np.full(len(n.unlabelled), -1))
    ),
    "chains of one": lambda n: replace(
        n,
        unlabelled=only(
            n.unlabelled,
            chain=np.arange(len(n.unlabelled)),
            chain_ids=tuple(map(str, range(len(n.unlabelled)))),
        ),
    ),
    "curves behind": lambda n: replace(
        n, curves=tuple(replace(each, values=each.values + [0.0, 0.0, 5000.0]) for each in n.curves)
    ),
}


@pytest.mark.parametrize("case", SOME)
def test_little_to_match(street: Network, case: str) -> None:
    network = SOME[case](street)
    found = match(network, KNOWN)
    assert_complete(network, found)
    none = case in ("no points", "one image, no curves", "curves behind")
    assert ((found.matches.curve >= 0).sum() == 0) == none


def test_excluded_points_and_images_without_orientation(street: Network) -> None:
    every = np.ones(len(street.unlabelled), dtype=bool)
    found = match(replace(street, unlabelled=only(street.unlabelled, excluded=every)), NEW)
    assert (found.matches.reason == Reason.EXCLUDED).all()
    images = street.images
    rotation, position = images.rotation.copy(), images.position.copy()
    rotation[3], position[3] = np.nan, np.nan
    network = replace(street, images=replace(images, rotation=rotation, position=position))
    found = match(network, replace(NEW, orient_freely=False))
    assert_complete(network, found)
    np.testing.assert_array_equal(found.matches.reason == Reason.NOT_ORIENTED, street.unlabelled.image == 3)
    assert np.isnan(found.eop_dispersion[3]).all() and not found.oriented[3]
    assert not found.network.images.has_orientation[3]


def test_the_sense_of_tracing_does_not_matter(street: Network) -> None:
    back = np.arange(len(street.unlabelled))[::-1]
    there, here = match(street, KNOWN).matches, match(with_rows(street, back), KNOWN).matches
    np.testing.assert_array_equal(here.curve, there.curve[back])


@pytest.mark.parametrize(("factor", "shift"), [(1e-6, 0.0), (1e3, 0.0), (1.0, 5e6)])
@pytest.mark.parametrize("new", [False, True])
def test_neither_size_nor_origin_matters(street: Network, factor: float, shift: float, new: bool) -> None:
    """A block of millimetres, one of a thousand kilometres, and one with coordinates of UTM."""
    settings = replace(NEW, position_sigma_m=0.5 * factor)
    curves: tuple[Curve, ...] = tuple(
        replace(each, values=each.values * factor + shift) for each in street.curves if not new
    )
    images = replace(street.images, position=street.images.position * factor + shift)
    usual = match(replace(street, curves=() if new else street.curves), NEW)
    other = match(replace(street, images=images, curves=curves), settings)
    assert len(other.built) == len(usual.built) == (3 if new else 0)
    assert (other.matches.curve != usual.matches.curve).mean() < 0.005


@pytest.mark.parametrize("family", ["natural_cubic", "circle", "conic", "fourier", ""])
def test_closed_curves(family: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    circle = np.column_stack([50.0 * np.cos(angle), 50.0 * np.sin(angle), np.full(120, 10.0)])
    network = scene([circle]).network
    axes = np.array([[0.0, 0.0, 10.0], [50.0, 0.0, 0.0], [0.0, 50.0, 0.0]])
    values = {"natural_cubic": circle[::10], "fourier": np.vstack([axes, np.zeros((2, 3))])}.get(family, axes)
    closed = {"closed": True} if family == "natural_cubic" else {}
    curves = (curve(family, values, **closed),) if family else ()
    found = match(replace(network, curves=curves), NEW)
    assert (found.matches.curve == 0).mean() > 0.98
    assert len(found.network.curves) == 1
