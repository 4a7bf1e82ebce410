"""The block from above or from the side: stations, footprints, splines by role, points, ellipses, scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import ROLE_COLOURS, STATION, svg_of
from splinebba_cli.report.footprints import footprints
from splinebba_cli.report.object_view import (
    ObjectView,
    looks_down,
    needs_side_view,
    plan_view,
    side_view,
    stations,
)
from splinebba_cli.report.plan_ellipses import draw_ellipses
from splinebba_cli.report.plan_frame import Labels, finish
from splinebba_cli.report.plan_tips import point_tip, spline_tip, station_tip
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import Tips

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELLED_IMAGES, _LABELLED_SPLINES, _DRAWN_POINTS = 60, 40, 3000
_VERTICES = 4000  # of all splines of a role together
_MARKERS = {"control": "^", "partial": "v", "tie": "o", "check": "s"}
_MAP = 20.0  # m between stations
_AXIS = 0.06  # length of a viewing direction, of the extent


def block_plan(data: ResultData) -> str:
    """SVG of the plan; X to the right, Y up, metres."""
    return _drawn(plan_view(data), footprints(data), north_or_y(data))


def block_elevation(data: ResultData) -> str:
    """SVG of the block from the side, Z up; empty where the plan says enough."""
    return "" if not needs_side_view(data) else _drawn(side_view(data), {}, "Z")


def north_or_y(data: ResultData) -> str:
    """What the arrow of a plan says: north where the block can be a map."""
    centres = stations(data)
    wide = len(centres) > 0 and float(np.ptp(centres[:, :2], axis=0).max()) > _MAP
    return "N" if wide and looks_down(data) else "Y"


def _drawn(view: ObjectView, covered: dict[str, FloatArray], upwards: str) -> str:
    extent = view.extent(list(covered.values()))
    width, height = extent[1] - extent[0]
    size = (7.6, float(np.clip(6.6 * height / max(width, 1e-9) + 0.9, 3.2, 6.4)))
    tips = Tips()

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        _draw_footprints(axes, covered, tips)
        labels = Labels(axes)
        _draw_splines(axes, view, tips)
        _draw_points(axes, view, tips)
        _draw_directions(axes, view, covered, extent)
        draw_ellipses(axes, view, extent, tips)
        _draw_stations(axes, view, tips, labels)
        _label_splines(view, labels)
        finish(axes, view.name, extent, upwards)
        figure.legend(loc="outside lower center", ncols=4, fontsize=8)
        labels.thin_out()

    return svg_of(draw, size, f"block {view.name}", tips=tips, kind="map")


def _draw_footprints(axes: Axes, covered: dict[str, FloatArray], tips: Tips) -> None:
    from matplotlib.collections import PolyCollection

    if not covered:
        return
    corners = list(covered.values())
    fill = max(0.06 * min(1.0, 30 / len(covered)), 0.008)  # many lie on top of each other
    axes.add_collection(PolyCollection(corners, facecolors=STATION, alpha=fill, linewidths=0))
    edges = PolyCollection(corners, facecolors="none", edgecolors=STATION, alpha=0.45, linewidths=0.6)
    tips.on(edges, [f"footprint of image {name}" for name in covered])
    axes.add_collection(edges)


def _draw_splines(axes: Axes, view: ObjectView, tips: Tips) -> None:
    from matplotlib.collections import LineCollection

    for role, colour in ROLE_COLOURS.items():
        splines = [spline for spline in view.data["splines"] if spline["role"] == role]
        drawn = [(spline, line) for spline in splines if len(line := view.polyline(spline)) > 1]
        if not drawn:
            continue
        step = 1 + sum(len(line) for _, line in drawn) // _VERTICES
        lines = [_thinned(line, step) for _, line in drawn]
        collection = LineCollection(lines, colors=colour, linewidths=1.8, label=f"{role} spline")
        tips.on(collection, [spline_tip(view.data, spline) for spline, _ in drawn])
        axes.add_collection(collection)


def _label_splines(view: ObjectView, labels: Labels) -> None:
    if len(view.data["splines"]) <= _LABELLED_SPLINES:
        for spline in view.data["splines"]:
            if spline["knots"]:
                x, y = (spline["knots"][len(spline["knots"]) // 2][axis] for axis in view.axes)
                labels.add(spline["id"], x, y, ROLE_COLOURS[spline["role"]])


def _thinned(line: FloatArray, step: int) -> FloatArray:
    """Every `step`-th vertex and the last one."""
    return line if step == 1 else np.concatenate([line[:-1:step], line[-1:]])


def _draw_points(axes: Axes, view: ObjectView, tips: Tips) -> None:
    step = 1 + len(view.data["points"]) // _DRAWN_POINTS
    for role, marker in _MARKERS.items():
        points = [point for point in view.data["points"] if point["role"] == role]
        drawn = points[::step] if role == "tie" else points
        xy = view.points(drawn)
        known = np.flatnonzero(np.isfinite(xy).all(axis=1))
        drawn, xy = [drawn[k] for k in known], xy[known]
        if drawn:
            name = f"{role} point" + (f" (1 of {step})" if step > 1 and role == "tie" else "")
            size = (3.0 if role == "tie" else 5.0) * max(0.4, min(1.0, (200 / len(drawn)) ** 0.5))
            (marks,) = axes.plot(
                xy[:, 0], xy[:, 1], marker, color=ROLE_COLOURS[role], markersize=size, label=name, mew=0
            )
            tips.on(marks, [point_tip(point) for point in drawn])


def _draw_directions(
    axes: Axes, view: ObjectView, covered: dict[str, FloatArray], extent: FloatArray
) -> None:
    """Where images without a footprint look."""
    from matplotlib.collections import LineCollection

    aside = [i for i, image in enumerate(view.data["images"]) if image["id"] not in covered]
    if not aside or len(aside) > _DRAWN_POINTS:
        return
    start = view.stations[aside]
    ends = start + _AXIS * float((extent[1] - extent[0]).max()) * view.directions[aside]
    lines = np.stack([start, ends], axis=1)
    axes.add_collection(
        LineCollection(list(lines), colors=STATION, linewidths=0.9, alpha=0.7, label="viewing direction")
    )


def _draw_stations(axes: Axes, view: ObjectView, tips: Tips, labels: Labels) -> None:
    xy, images = view.stations, view.data["images"]
    if not len(xy):
        return
    size = 7.0 * max(0.4, min(1.0, (150 / len(xy)) ** 0.5))
    (marks,) = axes.plot(
        xy[:, 0], xy[:, 1], "+", color=STATION, markersize=size, mew=0.2 * size, label="camera station"
    )
    tips.on(marks, [station_tip(image) for image in images])
    if len(xy) <= _LABELLED_IMAGES:
        for image, place in zip(images, xy, strict=True):
            labels.add(image["id"], place[0], place[1], STATION)
