"""Where in the block errors of measurements would be found.

The redundancy number r is the share of an error that its own residual shows. Points enter with x and y, image points
on splines across.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import CLASS_COLOURS, svg_of
from splinebba_cli.report.object_view import ObjectView, looks_down, plan_view, side_view
from splinebba_cli.report.plan_figure import north_or_y
from splinebba_cli.report.plan_frame import finish
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import Tips
from splinebba_cli.report.testable_means import mean_of_tested
from splinebba_cli.report.value_classes import ValueClasses, redundancy_classes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PARTS, _PARTS_IN_ALL = 40, 3000  # of a spline; of all splines
_POINTS = 3000


def redundancy_map(data: ResultData) -> str:
    """SVG: the block, splines and points coloured by the mean redundancy number of their measurements."""
    table = data.residuals
    if not table.rows:
        return ""
    view = plan_view(data) if looks_down(data) else side_view(data)
    classes = redundancy_classes()
    r, tips = mean_of_tested(table, "redundancy_{}"), Tips()
    size = (7.6, 5.0)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        shown = _draw_splines(axes, view, classes, tips) + _draw_points(axes, view, r, classes, tips)
        every = np.concatenate([part for part in shown if len(part)] or [np.zeros((1, 2))])
        extent = np.array([every.min(axis=0), np.maximum(every.max(axis=0), every.min(axis=0) + 1e-6)])
        finish(axes, view.name, extent, "Z" if view.up == 2 else north_or_y(data))
        classes.legend(figure)

    return svg_of(draw, size, "redundancy_map", tips=tips, kind="map")


@dataclass(frozen=True)
class _Part:
    """A part of a spline with the redundancy numbers of the image points on it."""

    line: FloatArray  # (n, 2)
    mean: float
    tip: str


def _draw_splines(axes: Axes, view: ObjectView, classes: ValueClasses, tips: Tips) -> list[FloatArray]:
    """Splines in parts, each with the mean of the image points on it; what is drawn."""
    from matplotlib.collections import LineCollection

    parts = [part for spline in view.data["splines"] for part in _parts(view, spline)]
    number = classes.of(np.array([part.mean for part in parts]))
    for k, colour in enumerate(CLASS_COLOURS):
        chosen = [parts[i] for i in np.flatnonzero(number == k)]
        drawn = LineCollection([part.line for part in chosen], colors=colour, linewidths=3.0)
        tips.on(drawn, [part.tip for part in chosen])
        axes.add_collection(drawn)
    return [part.line for part in parts]


def _parts(view: ObjectView, spline: dict[str, Any]) -> Iterator[_Part]:
    """Parts of one spline that have image points."""
    samples = view.data.samples_by_spline.get(spline["id"])
    found = view.data.redundancy_along.get(spline["id"])
    if samples is None or found is None or len(samples.u) < 2:
        return
    u, r = found
    count = max(4, min(_PARTS, _PARTS_IN_ALL // len(view.data["splines"])))
    edges = np.linspace(0, len(samples.u) - 1, min(count, len(samples.u) - 1) + 1).round().astype(int)
    place = np.clip(np.searchsorted(samples.u[edges], u, side="right") - 1, 0, len(edges) - 2)
    for k in range(len(edges) - 1):
        inside = r[(place == k) & np.isfinite(r)]
        if len(inside):
            yield _Part(
                samples.xyz[edges[k] : edges[k + 1] + 1, view.axes],
                float(inside.mean()),
                f"spline {spline['id']}: mean r {inside.mean():.2f}\n"
                f"{len(inside)} image points, least r {inside.min():.2f}",
            )


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
            f"point {point['id']}: mean r {mean:.2f}\n{len(rays[point['id']])} rays, "
            f"least r {min(rays[point['id']]):.2f}"
            for point, mean in zip(points, means, strict=True)
        ],
    )
    return [xy]
