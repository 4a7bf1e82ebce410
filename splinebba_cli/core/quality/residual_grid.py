"""Mean residual vectors in the cells of the image format, over all images of a camera.

Weighted least squares of one vector m a cell, with the sensitivity s of every row (photo_rows.py) and v whitened,

    m = (sum s s')^-1 sum s v,   Q_mm = (C'C)^-1 C'R C (C'C)^-1

A point gives both components, a point on a curve the one across it.  The test of a cell is that of bias_tests.py.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import ResidualGrid, SystematicEffect
from splinebba_cli.core.network import Camera, FloatArray, IntArray
from splinebba_cli.core.quality.bias_tests import TestFamily, bias_tests
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Statistics
from splinebba_cli.core.row_groups import split_by

ROWS_OF_A_CELL = 20  # aimed at, on average
MOST_CELLS = 9  # along the longer side
FEWEST = 6  # rows of a cell
WORTH = 4  # times the work of other families: few directions, for all images
ONE_DIRECTION = 0.05  # ratio of the information in both components below which a cell is not determined


def residual_grids(
    projector: ResidualProjector, rows: PhotoRows, statistics: Statistics
) -> tuple[tuple[ResidualGrid, ...], list[SystematicEffect]]:
    """Grids of all cameras, and the test of the cell with the largest statistic of each; alpha for all cells."""
    network = projector.assembler.prepared.network
    cells = []
    for camera, own in zip(network.cameras, split_by(rows.camera, len(network.cameras)), strict=True):
        if len(own) >= 4 * FEWEST:
            cells.append(_Cells(camera, rows, own))
    count = sum(len(each.members) for each in cells)
    if not count or 2 * count > WORTH * projector.affordable:
        return (), []
    family = TestFamily.of(statistics, network.settings.testing, network.settings.alpha, count)
    grids, effects = [], []
    for each in cells:
        grid, effect = each.tested(projector, family)
        grids.append(grid)
        effects += [effect] if effect is not None else []
    return tuple(grids), effects


class _Cells:
    """The rows of one camera, cell by cell."""

    def __init__(self, camera: Camera, rows: PhotoRows, own: IntArray) -> None:
        self.camera, self.rows = camera, rows
        xy = rows.xy[own] + camera.principal_point_mm
        self.x_edges, self.y_edges = grid_edges(xy, camera.format_mm)
        column = np.clip(np.searchsorted(self.x_edges, xy[:, 0]) - 1, 0, len(self.x_edges) - 2)
        line = np.clip(np.searchsorted(self.y_edges, xy[:, 1]) - 1, 0, len(self.y_edges) - 2)
        self.shape = (len(self.y_edges) - 1, len(self.x_edges) - 1)
        cell = line * self.shape[1] + column
        self.count = np.bincount(cell, minlength=self.shape[0] * self.shape[1]).astype(float)
        self.members = {
            k: own[rows_of_cell]
            for k, rows_of_cell in enumerate(split_by(cell, self.count.size))
            if len(rows_of_cell) >= FEWEST and self._both(own[rows_of_cell])
        }

    def _both(self, own: IntArray) -> bool:
        """Whether the rows of a cell determine both components."""
        values = np.linalg.eigvalsh(self.rows.sensitivity[own].T @ self.rows.sensitivity[own])
        return bool(values[0] > ONE_DIRECTION * values[1])

    def tested(
        self, projector: ResidualProjector, family: TestFamily
    ) -> tuple[ResidualGrid, SystematicEffect | None]:
        """Means with their sigma, and the test of the worst cell."""
        members = list(self.members.values())
        blocks = [self.rows.directions(own, np.repeat(np.eye(2)[None], len(own), axis=0)) for own in members]
        mean, sigma = np.full((self.count.size, 2), np.nan), np.full((self.count.size, 2), np.nan)
        tests = bias_tests(projector, blocks, family)
        for k, test in zip(self.members, tests, strict=True):
            mean[k], sigma[k] = -test.plain, test.plain_sigma
        grid = ResidualGrid(
            self.camera.id, self.x_edges, self.y_edges, mean.reshape(*self.shape, 2),
            sigma.reshape(*self.shape, 2), self.count.reshape(self.shape),
        )  # fmt: skip
        if not any(test.freedom for test in tests):
            return grid, None
        worst = min(range(len(tests)), key=lambda k: tests[k].probability)
        test, k = tests[worst], list(self.members)[worst]
        critical = family.critical(test.freedom)
        beyond = sum(t.freedom > 0 and t.statistic > family.critical(t.freedom) for t in tests)
        x, y = (
            _interval(edges, int(n))
            for edges, n in zip((self.x_edges, self.y_edges), self._place(k), strict=True)
        )
        size = 1e3 * float(np.hypot(*mean[k]))
        detail = f"cell x {x} mm, y {y} mm; {beyond} of {len(tests)} cells beyond the critical value"
        return grid, SystematicEffect(
            "grid", f"camera `{self.camera.id}`", size, "µm", test.statistic, critical,
            bool(test.statistic > critical), len(members[worst]), detail, test.shown, family.of_all(test.probability),
        )  # fmt: skip

    def _place(self, cell: int) -> tuple[int, int]:
        return cell % self.shape[1], cell // self.shape[1]


def _interval(edges: FloatArray, number: int) -> str:
    return f"{edges[number]:.1f} … {edges[number + 1]:.1f}".replace("-", "−")


def grid_edges(xy: FloatArray, format_mm: tuple[float, float] | None) -> tuple[FloatArray, FloatArray]:
    """Edges of nearly square cells over the format and all measured points (n, 2), mm."""
    low, high = xy.min(axis=0), xy.max(axis=0)
    if format_mm is not None:
        half = 0.5 * np.array(format_mm)
        low, high = np.minimum(low, -half), np.maximum(high, half)
    extent = np.maximum(high - low, 1e-9)
    wanted = max(len(xy) / ROWS_OF_A_CELL, 4.0)
    side = max(float(np.sqrt(extent.prod() / wanted)), float(extent.max()) / MOST_CELLS)
    number = np.maximum(np.round(extent / side), 1.0).astype(int)
    return np.linspace(low[0], high[0], number[0] + 1), np.linspace(low[1], high[1], number[1] + 1)
