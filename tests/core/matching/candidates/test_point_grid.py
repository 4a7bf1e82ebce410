"""Points in boxes, by cells."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.candidates.point_grid import PointGrid, expand


def test_every_point_of_a_box_is_in_its_ranges_once_and_few_others() -> None:
    g = np.random.default_rng(1)
    image, xy = g.integers(0, 4, 500), g.normal(0.0, [10.0, 3.0], (500, 2))
    image[image == 2] = 1  # an image without points
    points = np.flatnonzero(g.uniform(size=500) < 0.8)
    xy[points[0]] = xy[points].max(axis=0)  # on the last corner of a grid, perhaps
    size = np.array([1.0, 0.01, 1.0, 1e9])  # the second is made larger, the last is one cell
    grid = PointGrid.of(image, xy, size, points)
    assert grid.columns[3] == grid.rows[3] == 1
    assert grid.starts[-1] == len(points) and len(grid.starts) < 6 * 500
    own = g.integers(0, 4, 200)
    low = g.normal(0.0, 8.0, (2, 200))
    high = low + g.uniform(0.0, 6.0, (2, 200))
    low[:, 0], high[:, 0] = -1e9, 1e9
    box, place = expand(*grid.ranges(own, low, high)[1:])
    box = grid.ranges(own, low, high)[0][box]
    pairs = set(zip(box.tolist(), grid.points[place].tolist(), strict=True))
    assert len(pairs) == len(box)
    for k in range(200):
        inside = (image == own[k]) & (np.clip(xy, low[:, k], high[:, k]) == xy).all(axis=1)
        expected = {(k, int(point)) for point in points if inside[point]}
        assert expected <= pairs
    for k, point in pairs:
        cell = grid.cell[own[k]]
        assert image[point] == own[k]
        assert (xy[point] >= low[:, k] - cell).all() and (xy[point] <= high[:, k] + cell).all()


def test_ranges_are_counted_through() -> None:
    owner, number = expand(np.array([3, 7, 7]), np.array([5, 7, 9]))
    assert owner.tolist() == [0, 0, 2, 2]
    assert number.tolist() == [3, 4, 7, 8]
