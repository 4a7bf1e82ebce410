"""Mean residual vectors over the image format of one camera, as enlarged arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import GRID, INK, MUTED, STATION, WARN, svg_of
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import grouped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FILLED = 0.45  # of a cell: length of the longest arrow
_SIGNIFICANT = 3.0  # σ of a mean


def residual_grid(data: ResultData, camera: str) -> str:
    """SVG: arrows of the mean residuals, three-σ circles; arrows longer than three σ in the colour of warnings."""
    found = [grid for grid in data["systematic"]["grids"] if grid["camera"] == camera]
    if not found:
        return ""
    grid = found[0]
    x_edges, y_edges = np.array(grid["x_edges_mm"]), np.array(grid["y_edges_mm"])
    mean, sigma = _array(grid["mean_mm"]), _array(grid["sigma_mm"])
    cell = min(float(np.diff(x_edges).min()), float(np.diff(y_edges).min()))
    size = np.hypot(mean[..., 0], mean[..., 1])
    largest = float(np.nanmax(size)) if np.isfinite(size).any() else 0.0
    if largest <= 0.0:
        return ""
    scale = _round_scale(largest, _FILLED * cell)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        for edges, line in ((x_edges, axes.axvline), (y_edges, axes.axhline)):
            for edge in edges:
                line(edge, color=GRID, linewidth=0.6)
        axes.grid(visible=False)
        _arrows(axes, (x_edges, y_edges), scale * mean, scale * sigma)
        axes.set_xlim(x_edges[0], x_edges[-1])
        axes.set_ylim(y_edges[0], y_edges[-1])
        axes.set_aspect("equal")
        axes.set_xlabel("x [mm]")
        axes.set_ylabel("y [mm]")
        axes.set_title(f"enlarged {grouped(scale)} times, longest {1e3 * largest:.2g} µm")

    ratio = float((y_edges[-1] - y_edges[0]) / (x_edges[-1] - x_edges[0]))
    return svg_of(draw, (7.6, 0.6 + min(6.4 * ratio, 4.6)), f"residual_grid_{camera}")


def _array(rows: list[Any]) -> FloatArray:
    return np.array(rows, dtype=float)


def _round_scale(largest: float, room: float) -> float:
    """An enlargement of one, two or five times a power of ten."""
    scale = room / largest
    power = 10.0 ** np.floor(np.log10(scale))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= scale) * power)


def _arrows(axes: Axes, edges: tuple[FloatArray, FloatArray], mean: FloatArray, sigma: FloatArray) -> None:
    from matplotlib.patches import Ellipse

    x, y = (0.5 * (each[1:] + each[:-1]) for each in edges)
    for j, i in np.argwhere(np.isfinite(mean).all(axis=2)):
        ratio = float(np.sqrt(np.sum((mean[j, i] / np.maximum(sigma[j, i], 1e-12)) ** 2)))
        colour = WARN if ratio > _SIGNIFICANT else STATION
        width, height = 2.0 * _SIGNIFICANT * sigma[j, i]
        axes.add_patch(Ellipse((x[i], y[j]), width, height, facecolor="none", edgecolor=MUTED, linewidth=0.5))
        axes.annotate(
            "",
            (x[i] + mean[j, i, 0], y[j] + mean[j, i, 1]),
            (x[i], y[j]),
            arrowprops={
                "arrowstyle": "->",
                "color": colour,
                "shrinkA": 0.0,
                "shrinkB": 0.0,
                "linewidth": 1.2,
            },
        )
        axes.plot(x[i], y[j], ".", color=INK, markersize=2)
