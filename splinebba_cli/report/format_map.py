"""Where in the image format errors of measurements would be found.

The redundancy number r is the share of an error that its own residual shows; the minimal detectable bias (MDB) is the
smallest error that the test finds with the declared power. Points enter with x and y, image points on splines across.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import CLASS_COLOURS, svg_of
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import Tips
from splinebba_cli.report.testable_means import mean_of_tested
from splinebba_cli.report.value_classes import ValueClasses, quantile_classes, redundancy_classes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CELLS = 8  # along the longer side of the format


def format_map(data: ResultData, camera: str) -> str:
    """SVG: mean redundancy number and median MDB in the cells of the image format of one camera."""
    found = format_cells(data, camera)
    if found is None:
        return ""
    (x_edges, y_edges), count, r, bias = found
    tips = Tips()
    ratio = float((y_edges[-1] - y_edges[0]) / (x_edges[-1] - x_edges[0]))

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, 2)
        both = (
            (panels[0], r, redundancy_classes(), "Mean redundancy number r"),
            (panels[1], bias, quantile_classes(bias, "MDB [µm]"), "Median MDB [µm]"),
        )
        for axes, values, classes, title in both:
            _draw_cells(axes, (x_edges, y_edges), (values, count), classes, tips, title)

    return svg_of(draw, (7.6, 1.3 + min(3.4 * ratio, 5.0)), f"format_map {camera}", tips=tips, kind="map")


def format_cells(
    data: ResultData, camera: str
) -> tuple[tuple[FloatArray, FloatArray], FloatArray, FloatArray, FloatArray] | None:
    """Edges of the cells in mm, number of image points, mean r and median MDB in µm, (rows, columns) upwards."""
    images = {image["id"] for image in data["images"] if image["camera"] == camera}
    table = data.residuals
    if not table.rows:
        return None
    chosen = np.array([image in images for image in table["image"]], dtype=bool)
    xy = np.stack([table.numbers(f"measured_{axis}_mm") for axis in "xy"], axis=1)
    r, bias = (
        mean_of_tested(table, "redundancy_{}"),
        1e3 * mean_of_tested(table, "minimal_detectable_bias_{}_mm"),
    )
    chosen &= np.isfinite(xy).all(axis=1) & np.isfinite(r)
    if not chosen.any() or not np.isfinite(bias[chosen]).any():
        return None
    xy, r, bias = xy[chosen], r[chosen], bias[chosen]
    given = next(each for each in data["cameras"] if each["id"] == camera)["format_mm"]
    half = np.abs(xy).max(axis=0) * 1.0001 if given is None else 0.5 * np.array(given, dtype=float)
    counts = np.maximum(np.round(_CELLS * half / half.max()), 2).astype(int)
    edges = [np.linspace(-h, h, n + 1) for h, n in zip(half, counts, strict=True)]
    column, row = (
        np.clip(np.searchsorted(edges[k], xy[:, k], side="right") - 1, 0, counts[k] - 1) for k in (0, 1)
    )
    cell = row * counts[0] + column
    shape = (counts[1], counts[0])
    number = np.bincount(cell, minlength=shape[0] * shape[1]).astype(float)
    mean, median = np.full(number.shape, np.nan), np.full(number.shape, np.nan)
    for k in np.flatnonzero(number):
        mean[k] = r[cell == k].mean()
        known = bias[(cell == k) & np.isfinite(bias)]
        median[k] = np.median(known) if len(known) else np.nan
    return (edges[0], edges[1]), number.reshape(shape), mean.reshape(shape), median.reshape(shape)


def _draw_cells(
    axes: Axes,
    edges: tuple[FloatArray, FloatArray],
    cells: tuple[FloatArray, FloatArray],
    classes: ValueClasses,
    tips: Tips,
    title: str,
) -> None:
    from matplotlib.collections import PolyCollection

    values, count = cells
    x, y = edges
    found = np.argwhere(np.isfinite(values))
    corners = [[(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])] for j, i in found]
    known = np.array([values[j, i] for j, i in found])
    colours = [CLASS_COLOURS[k] for k in classes.of(known)]
    drawn = PolyCollection(corners, facecolors=colours, linewidths=0)
    tips.on(drawn, [f"{title} {values[j, i]:.3g}\n{count[j, i]:.0f} image points" for j, i in found])
    axes.add_collection(drawn)
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_title(title)
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.locator_params(nbins=5)
    _legend_under(axes, classes)


def _legend_under(axes: Axes, classes: ValueClasses) -> None:
    from matplotlib.patches import Patch

    patches = [Patch(color=c, label=n) for c, n in zip(CLASS_COLOURS, classes.names(), strict=True)]
    axes.legend(
        handles=patches,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.2),
        ncols=3,
        fontsize=7.5,
        handlelength=1.2,
        columnspacing=1.0,
    )
