from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.row_groups import RowGroups
from splinebba_cli.core.tracks import Tracks, chunk_size, chunks_of
from tests.core.small_networks import mixed_network


def test_tracks_hold_every_point_once() -> None:
    seen = mixed_network()[0].curve_observations
    tracks = Tracks.of(seen)
    assert np.array_equal(np.sort(tracks.points), np.arange(len(seen)))
    assert np.array_equal(seen.curve[tracks.points], tracks.curve[tracks.of_place])
    assert np.array_equal(seen.image[tracks.points], tracks.image[tracks.of_place])
    pairs = set(zip(tracks.curve.tolist(), tracks.image.tolist(), strict=True))
    assert len(pairs) == len(tracks)


def test_no_points() -> None:
    seen = mixed_network()[0].curve_observations
    none = replace(seen, **{name: getattr(seen, name)[:0] for name in ("image", "curve")})
    assert len(Tracks.of(none)) == 0
    assert Tracks.of(none).chunks() == []


@pytest.mark.parametrize("count", [1, 59, 60, 61, 100, 1000, 12_345])
def test_chunks_are_even_in_number_and_not_too_large(count: int) -> None:
    size = chunk_size(count, 60)
    number = -(-count // size)
    assert size <= 60
    assert number == 1 or number % 2 == 0
    assert number <= 2 * -(-count // 120) or count <= 60


def test_slices_cover_all_groups() -> None:
    starts = np.array([0, 3, 4, 10, 10, 25, 26, 40])
    slices = chunks_of(starts, 8)
    assert [i for part in slices for i in range(part.start, part.stop)] == list(range(len(starts) - 1))


def test_batches_of_groups_of_different_width() -> None:
    """Every row once, groups of one batch of similar length and width."""
    generator = np.random.default_rng(4)
    keys = np.repeat(np.arange(40), generator.integers(1, 30, 40))
    groups = RowGroups.of(keys)
    width = generator.integers(1, 3000, 40)
    found = []
    for chosen, rows in groups.batches(width):
        assert width[chosen].max() <= 2 * width[chosen].min()
        counts = np.diff(groups.starts)[chosen]
        assert counts.max() <= counts.min() + max(1, counts.min() // 4)
        found.append(rows[rows < len(keys)])
    assert np.array_equal(np.sort(np.concatenate(found)), np.arange(len(keys)))
