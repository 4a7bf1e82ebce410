"""Several strands of one edge as one, in order."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.shapes.merging import merged
from splinebba_cli.core.matching.shapes.strand import Strand, strand_of
from splinebba_cli.core.network import FloatArray
from tests.core.matching.fragments.small_scenes import arc
from tests.core.matching.shapes.edges import fragment

EDGE = arc(40.0, 2.8)


def strand(each: Fragment) -> Strand:
    found = strand_of(each)
    assert found is not None
    return found


def part(low: int, high: int, seed: int, *, backwards: bool = False) -> Strand:
    """Places low .. high - 1 of the edge; the point of row n shows place n."""
    place = np.arange(low, high)[:: -1 if backwards else 1]
    noise = np.random.default_rng(seed).normal(0.0, 0.05, (len(place), 3))
    order = np.argsort(place)
    return strand(fragment(EDGE[place] + noise, 0.05, place[order], order.astype(float)))


def place_on_edge(xyz: FloatArray) -> FloatArray:
    distance = np.linalg.norm(xyz[:, None] - EDGE[None], axis=2)
    return np.asarray(distance.argmin(axis=1))


@pytest.mark.parametrize("backwards", [False, True])
def test_overlapping_strands_become_one_in_order(backwards: bool) -> None:
    whole = merged([part(0, 45, 1), part(30, len(EDGE), 2, backwards=backwards)])
    place = place_on_edge(whole.line)
    place = place if place[-1] > place[0] else place[::-1]
    assert place[0] <= 1
    assert place[-1] >= len(EDGE) - 2
    assert (np.diff(place) >= -1).all()
    length = np.linalg.norm(np.diff(EDGE, axis=0), axis=1).sum()
    assert whole.length == pytest.approx(length, rel=0.02)


def test_links_keep_their_places() -> None:
    whole = merged([part(0, 45, 1), part(30, len(EDGE), 2, backwards=True)])
    assert sorted(whole.link_row.tolist()) == list(range(len(EDGE)))
    along = np.argsort(whole.link_location)
    rows = whole.link_row[along]
    rows = rows if rows[-1] > rows[0] else rows[::-1]
    assert np.abs(rows - np.arange(len(EDGE))).max() <= 1


def test_without_common_points_the_places_tell_the_order() -> None:
    other = part(30, len(EDGE), 2, backwards=True)
    whole = merged([part(0, 45, 1), Strand(**{**vars(other), "link_row": other.link_row + 1000})])
    place = place_on_edge(whole.line)
    place = place if place[-1] > place[0] else place[::-1]
    assert (np.diff(place) >= -1).all()
    assert len(whole.link_row) == 45 + len(EDGE) - 30


def test_places_of_a_fragment_stay_in_its_order_around_a_hairpin() -> None:
    """A straight first fit of a bend must not lead the places astray."""
    bend = arc(8.0, 3.0)
    found = strand(fragment(bend + np.random.default_rng(3).normal(0.0, 0.05, bend.shape)))
    length = np.linalg.norm(np.diff(bend, axis=0), axis=1).sum()
    assert found.length == pytest.approx(length, rel=0.03)
