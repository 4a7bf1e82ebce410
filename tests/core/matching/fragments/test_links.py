"""Links of image points: near, in the direction of the fragment, one chain an image, confirmed from both sides."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.confirmed_links import confirmed
from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.link_table import Links
from splinebba_cli.core.matching.fragments.links import links_of
from splinebba_cli.core.matching.fragments.one_chain import one_chain_an_image
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

LENGTH = 10


def chains_of(images: list[int]) -> TracedChains:
    """One piece of ten points in every image that is named."""
    count = LENGTH * len(images)
    piece = np.repeat(np.arange(len(images)), LENGTH)
    return TracedChains(
        row=np.arange(count), image=np.repeat(images, LENGTH), piece=piece,
        start=LENGTH * np.arange(len(images) + 1), xy=np.zeros((count, 2)), arc=np.zeros(count),
        tangent=np.zeros((count, 2)), tangent_sigma=np.zeros(count), sigma=np.ones(count), ray=np.ones((count, 3)),
    )  # fmt: skip


def labels_of(count: int, links: list[tuple[int, float]]) -> LabelledPoints:
    table = np.array(sorted(links))
    value = np.ones(count)
    return LabelledPoints(
        value, value, value, value, np.ones(count, dtype=bool), np.zeros(count, dtype=bool),
        table[:, 0].astype(np.int64), table[:, 1],
    )  # fmt: skip


def stretch(first: int, there: int, count: int = LENGTH) -> list[tuple[int, float]]:
    return [(first + k, there + k + 0.3) for k in range(count)]


def kept(links: list[tuple[int, float]], partners: list[IntArray]) -> set[tuple[int, int]]:
    chains = chains_of([0, 1, 2])
    labels = confirmed(chains, labels_of(len(chains), links), partners)
    return set(zip(labels.link_point // LENGTH, labels.link_place.astype(np.int64) // LENGTH, strict=True))


ALL = [np.array([1, 2]), np.array([0, 2]), np.array([0, 1])]


def test_links_that_are_returned_stay() -> None:
    assert kept([*stretch(0, 9), *stretch(9, 0, 9)], ALL) == {(0, 0), (0, 1), (1, 0)} - {(0, 0)}


def test_links_that_are_not_returned_go() -> None:
    links = [*stretch(0, 10, 9), *stretch(10, 0, 9), *stretch(20, 10, 9)]
    assert kept(links, ALL) == {(0, 1), (1, 0)}


def test_links_of_images_that_were_not_asked_stay() -> None:
    links = [*stretch(0, 10, 9), *stretch(10, 0, 9), *stretch(20, 10, 9)]
    assert kept(links, [np.array([1]), np.array([0]), np.array([1])]) == {(0, 1), (1, 0), (2, 1)}


def test_a_touch_is_no_link() -> None:
    links = [*stretch(0, 10, 9), *stretch(10, 0, 9), (4, 24.2), (5, 25.2), (24, 4.0), (25, 5.0)]
    assert kept(links, ALL) == {(0, 1), (1, 0)}


def two_rows(z: tuple[FloatArray, FloatArray], image: int = 0) -> tuple[TracedChains, Links]:
    """Two chains, the first in image 0, linked to the same ten places."""
    place = np.arange(LENGTH, dtype=float)
    links = Links(
        np.zeros(2 * LENGTH, dtype=np.int64),
        np.arange(2 * LENGTH),
        np.concatenate([place, place]),
        np.concatenate(z),
    )
    return chains_of([0, image]), links


@pytest.mark.parametrize("better", [0, 1])
def test_of_two_chains_side_by_side_the_nearer_stays(better: int) -> None:
    z = (np.full(LENGTH, 0.2), np.full(LENGTH, 3.0))
    chains, links = two_rows(z if better == 0 else z[::-1])
    point = one_chain_an_image(chains, links).point
    assert (point // LENGTH == better).sum() == LENGTH
    assert (point // LENGTH != better).sum() <= 2  # at the very ends


def test_an_edge_that_was_traced_twice_keeps_both_chains() -> None:
    chains, links = two_rows((np.full(LENGTH, 0.2), np.full(LENGTH, 0.5)))
    assert len(one_chain_an_image(chains, links)) == 2 * LENGTH


def test_chains_of_different_images_do_not_compete() -> None:
    chains, links = two_rows((np.full(LENGTH, 0.2), np.full(LENGTH, 3.0)), image=1)
    assert len(one_chain_an_image(chains, links)) == 2 * LENGTH


def test_a_chain_cut_in_two_keeps_both_parts() -> None:
    """They overlap by one place; the worse part loses none."""
    place = np.arange(LENGTH, dtype=float)
    links = Links(
        np.zeros(2 * LENGTH, dtype=np.int64), np.arange(2 * LENGTH), np.concatenate([place, place + LENGTH - 2.0]),
        np.repeat([0.2, 3.0], LENGTH),
    )  # fmt: skip
    assert len(one_chain_an_image(chains_of([0, 0]), links)) == 2 * LENGTH


def linked(*chains: tuple[FloatArray, FloatArray], variance_m2: float = 1e-6) -> set[int]:
    """Numbers of the chains, points (10, 2) mm and tangent (2,), that a fragment along the x axis gets.

    One vertical image, c = 100 mm, 1 000 m high; sigma 3 micrometres.
    """
    count = LENGTH * len(chains)
    piece = np.repeat(np.arange(len(chains)), LENGTH)
    traced = TracedChains(
        row=np.arange(count), image=np.zeros(count, dtype=np.int64), piece=piece,
        start=LENGTH * np.arange(len(chains) + 1), xy=np.vstack([xy for xy, _ in chains]), arc=np.zeros(count),
        tangent=np.repeat([tangent for _, tangent in chains], LENGTH, axis=0), tangent_sigma=np.full(count, 0.03),
        sigma=np.full(count, 0.003), ray=np.ones((count, 3)),
    )  # fmt: skip
    views = Views(np.eye(3)[None], np.array([[0.0, 0.0, 1000.0]]), np.array([100.0]))
    xyz = np.column_stack([np.linspace(-10.0, 10.0, 41), np.zeros(41), np.zeros(41)])
    dispersion = np.tile(variance_m2 * np.eye(3), (41, 1, 1))
    found = links_of(views, traced, np.array([0, 41]), xyz, dispersion, 3.3, 0.35)
    place = (traced.xy[found.point, 0] + 1.0) * 20.0
    assert found.place == pytest.approx(place, abs=1e-9)
    return set((found.point // LENGTH).tolist())


ALONG = np.array([1.0, 0.0])


def chain_at(y_mm: float, step_mm: float = 0.06) -> FloatArray:
    return np.column_stack([step_mm * (np.arange(LENGTH) - 4.5), np.full(LENGTH, y_mm)])


@pytest.mark.parametrize(("y_mm", "near"), [(0.009, True), (0.011, False)])
def test_points_within_the_gate_are_linked(y_mm: float, near: bool) -> None:
    assert linked((chain_at(y_mm), ALONG)) == ({0} if near else set())


@pytest.mark.parametrize(("y_mm", "near"), [(0.030, True), (0.035, False)])
def test_an_uncertain_fragment_widens_the_gate_to_a_limit(y_mm: float, near: bool) -> None:
    """A metre is 0.1 mm, 33 sigma; it counts as three, so that the gate is 3.3 sqrt(10) sigma, 0.031 mm."""
    xy = chain_at(y_mm) * np.array([1.0, -1.0]) ** np.arange(LENGTH)[:, None]  # on both sides
    assert linked((xy, ALONG), variance_m2=1.0) == ({0} if near else set())


@pytest.mark.parametrize(("turn", "same"), [(0.4, True), (0.5, False), (np.pi - 0.4, True)])
def test_chains_of_another_direction_are_not_linked(turn: float, same: bool) -> None:
    """Tolerance 0.35 and 3.3 times 0.03; either sense."""
    tangent = np.array([np.cos(turn), np.sin(turn)])
    assert linked((chain_at(0.0, 0.0005), tangent)) == ({0} if same else set())


def test_the_farther_of_two_chains_side_by_side_is_not_linked() -> None:
    assert linked((chain_at(0.0), ALONG), (chain_at(0.009, 0.05), ALONG)) == {0}


def test_two_points_in_a_row_are_not_enough() -> None:
    xy = chain_at(0.0)
    xy[2:, 1] = 1.0
    assert linked((xy, ALONG)) == set()
