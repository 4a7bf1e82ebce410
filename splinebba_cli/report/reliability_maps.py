"""Where in the block, and where in the image format, errors of measurements would be found.

The redundancy number r is the share of an error that its own residual shows; the minimal detectable bias (MDB) is the
smallest error that the test finds with the declared power. Points enter with x and y, image points on splines across.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.output.read_table import ReadTable
from splinebba_cli.report.canvas import CLASS_COLOURS, svg_of
from splinebba_cli.report.object_view import ObjectView, looks_down, plan_view, side_view
from splinebba_cli.report.plan_frame import finish
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import Tips
from splinebba_cli.report.value_classes import ValueClasses, quantile_classes, redundancy_classes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CELLS = 8  # along the longer side of the format
_PARTS, _PARTS_IN_ALL = 40, 4000  # of a spline; of all splines
_POINTS = 3000
_NAMES = ("x", "y", "across")


def redundancy_map(data: ResultData) -> str:
    """SVG: the block, splines and points coloured by the mean redundancy number of their measurements."""
    table = data.residuals
    if not table.rows:
        return ""
    view = plan_view(data) if looks_down(data) else side_view(data)
    classes = redundancy_classes()
    r, tips = _least(table, "redundancy_{}"), Tips()
    size = (7.6, 5.0)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        shown = _draw_splines(axes, view, classes, tips) + _draw_points(axes, view, r, classes, tips)
        every = np.concatenate([part for part in shown if len(part)] or [np.zeros((1, 2))])
        extent = np.array([every.min(axis=0), np.maximum(every.max(axis=0), every.min(axis=0) + 1e-6)])
        finish(axes, view.name, extent, "N" if view.name == "XY" and looks_down(data) else view.name[1])
        classes.legend(figure)

    return svg_of(draw, size, "redundancy_map", tips=tips, kind="map")


def _least(table: ReadTable, name: str) -> FloatArray:
    """Mean over the tested components of every image point, (n,)."""
    values = np.stack([table.numbers(name.format(each)) for each in _NAMES])
    count = np.isfinite(values).sum(axis=0)
    return np.divide(np.nansum(values, axis=0), count, out=np.full(len(count), np.nan), where=count > 0)


def _draw_splines(axes: Axes, view: ObjectView, classes: ValueClasses, tips: Tips) -> list[FloatArray]:
    """Splines in parts, each with the mean of the image points on it; what is drawn."""
    from matplotlib.collections import LineCollection

    data = view.data
    lines, means, says = [], [], []
    parts = max(4, min(_PARTS, _PARTS_IN_ALL // max(len(data["splines"]), 1)))
    values = redundancy_along(data)
    for spline in data["splines"]:
        samples, found = data.samples_by_spline.get(spline["id"]), values.get(spline["id"])
        if samples is None or found is None or len(samples.u) < 2:
            continue
        u, r = found
        edges = np.linspace(0, len(samples.u) - 1, min(parts, len(samples.u) - 1) + 1).round().astype(int)
        place = np.clip(np.searchsorted(samples.u[edges], u, side="right") - 1, 0, len(edges) - 2)
        for k in range(len(edges) - 1):
            inside = r[place == k]
            inside = inside[np.isfinite(inside)]
            if not len(inside):
                continue
            lines.append(samples.xyz[edges[k] : edges[k + 1] + 1, view.axes])
            means.append(float(inside.mean()))
            says.append(
                f"spline {spline['id']}: mean r {inside.mean():.2f}\n{len(inside)} image points, least r {inside.min():.2f}"
            )
    if lines:
        colours = [CLASS_COLOURS[k] for k in classes.of(np.array(means))]
        drawn = LineCollection(lines, colors=colours, linewidths=3.0)
        tips.on(drawn, says)
        axes.add_collection(drawn)
    return lines


def redundancy_along(data: ResultData) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Locations u and redundancy numbers across of the image points of every spline that take part."""
    table, locations = data.image_points, data.locations
    on_spline = np.array([kind == "spline" for kind in table["kind"]], dtype=bool)
    if on_spline.sum() != locations.rows:
        return {}
    r = np.where(data.taking_part, table.numbers("redundancy_across"), np.nan)[on_spline]
    u = locations.numbers("u")
    names, number = np.unique(np.array(list(locations["spline"]), dtype=object), return_inverse=True)
    order = np.argsort(number, kind="stable")
    ends = np.searchsorted(number[order], np.arange(len(names) + 1))
    chosen = [order[ends[i] : ends[i + 1]] for i in range(len(names))]
    return {str(name): (u[rows], r[rows]) for name, rows in zip(names, chosen, strict=True)}


def _draw_points(
    axes: Axes, view: ObjectView, r: FloatArray, classes: ValueClasses, tips: Tips
) -> list[FloatArray]:
    """Points with the mean over their rays, those with the least first; what is drawn."""
    table = view.data.residuals
    rays: dict[str, list[float]] = {}
    for kind, feature, value in zip(table["kind"], table["feature"], r.tolist(), strict=True):
        if kind == "point" and np.isfinite(value):
            rays.setdefault(feature, []).append(value)
    points = [point for point in view.data["points"] if point["id"] in rays]
    points.sort(key=lambda point: float(np.mean(rays[point["id"]])))
    points = points[:_POINTS]
    xy = view.points(points)
    if not points:
        return []
    means = np.array([np.mean(rays[point["id"]]) for point in points])
    colours = [CLASS_COLOURS[k] for k in classes.of(means)]
    marks = axes.scatter(
        xy[:, 0], xy[:, 1], s=22.0 * max(0.15, min(1.0, 200 / len(xy))), c=colours, linewidths=0
    )
    tips.on(
        marks,
        [
            f"point {point['id']}: mean r {mean:.2f}\n{len(rays[point['id']])} rays, least r {min(rays[point['id']]):.2f}"
            for point, mean in zip(points, means, strict=True)
        ],
    )
    return [xy]


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
    r, bias = _least(table, "redundancy_{}"), 1e3 * _least(table, "minimal_detectable_bias_{}_mm")
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
