"""Check features: differences of check points as vectors and bars, distances of check splines with their band."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import MUTED, ROLE_COLOURS, WARN, svg_of
from splinebba_cli.report.object_view import coordinates
from splinebba_cli.report.plan_frame import Labels
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import Scale, grouped, length_scale, round_length
from splinebba_cli.report.svg_text import Tips, visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPLINES = 12  # check splines with a figure, those with the largest distance
_LABELLED, _LONG, _BAND = 40, 0.12, 1.96
_KEYS = ("difference", "sigma")  # of a check point
_CHI2 = 5.991  # 95 % of χ² with two degrees of freedom


def check_points_figure(data: ResultData) -> str:
    """SVG: horizontal differences in the plan, height differences with ± 1.96 σ; empty without check points."""
    places = {point["id"]: point for point in data["points"]}
    found = [point for point in data["checks"]["points"] if point["id"] in places]
    if not found:
        return ""
    xy = coordinates([[places[point["id"]][axis] for axis in "xyz"] for point in found])[:, :2]
    difference, sigma = (coordinates([[point[key][a] for a in "xyz"] for point in found]) for key in _KEYS)
    scale, tips = length_scale(difference.ravel().tolist()), Tips()
    says = [_tip(p["id"], d, s, scale) for p, d, s in zip(found, difference, sigma, strict=True)]
    failed = np.array([not point.get("passed", True) for point in found])

    def draw(figure: Figure) -> None:
        plan, heights = figure.subplots(1, 2, width_ratios=(1.1, 1.0))
        names = [point["id"] for point in found]
        labels = _draw_vectors(plan, data, (xy, difference[:, :2], failed), names, tips, says)
        _draw_heights(heights, (difference[:, 2], sigma[:, 2], failed), names, scale, tips, says)
        labels.thin_out()

    return svg_of(draw, (7.6, 3.6), "check_points", tips=tips, kind="map")


def _tip(name: str, difference: FloatArray, sigma: FloatArray, scale: Scale) -> str:
    rows = [
        f"Δ{axis} {scale.text(float(d))}, σ {scale.text(float(s))}"
        for axis, d, s in zip("XYZ", difference, sigma, strict=True)
    ]
    return "\n".join([f"check point {name}", *rows])


def _draw_vectors(
    axes: Axes,
    data: ResultData,
    vectors: tuple[FloatArray, FloatArray, Any],
    names: list[str],
    tips: Tips,
    says: list[str],
) -> Labels:
    from matplotlib.collections import LineCollection

    xy, difference, failed = vectors
    every = np.concatenate([xy, coordinates([[i[a] for a in "xyz"] for i in data["images"]])[:, :2]])
    span = float(np.ptp(every, axis=0).max())
    longest = float(np.hypot(*difference.T).max())
    factor = round_length(_LONG * span / longest) if longest > 0.0 and span > 0.0 else 1.0
    axes.set_aspect("equal", adjustable="datalim")
    axes.plot(every[len(xy) :, 0], every[len(xy) :, 1], "+", color=MUTED, markersize=4)
    colours = [WARN if each else ROLE_COLOURS["check"] for each in failed]
    lines = LineCollection(
        list(np.stack([xy, xy + factor * difference], axis=1)), colors=colours, linewidths=1.6
    )
    tips.on(lines, says)
    axes.add_collection(lines)
    marks = axes.scatter(xy[:, 0], xy[:, 1], s=14, c=colours, marker="s", linewidths=0)
    tips.on(marks, says)
    labels = Labels(axes)
    if len(names) <= _LABELLED:
        for name, place in zip(names, xy, strict=True):
            labels.add(name, place[0], place[1], MUTED)
    axes.autoscale_view()
    axes.margins(0.08)
    axes.locator_params(nbins=4)
    axes.set_title(f"ΔX, ΔY enlarged {grouped(factor)} times")
    axes.set_xlabel("X [m]")
    axes.set_ylabel("Y [m]")
    return labels


def _draw_heights(
    axes: Axes,
    heights: tuple[FloatArray, FloatArray, Any],
    names: list[str],
    scale: Scale,
    tips: Tips,
    says: list[str],
) -> None:
    difference, sigma, failed = heights
    place = np.arange(len(names))
    band = _BAND * scale.factor * np.nan_to_num(sigma)
    axes.vlines(place, -band, band, color=MUTED, alpha=0.45, linewidth=min(7.0, 200.0 / len(names)))
    colours = [WARN if each else ROLE_COLOURS["check"] for each in failed]
    bars = axes.vlines(
        place, 0.0, scale.factor * difference, color=colours, linewidth=min(3.0, 100.0 / len(names))
    )
    tips.on(bars, says)
    axes.axhline(0.0, color=MUTED, linewidth=0.8)
    if len(names) <= _LABELLED:
        axes.set_xticks(place, [visible(name, 12) for name in names], rotation=90 if len(names) > 5 else 0)
    axes.set_xlim(-0.8, len(names) - 0.2)
    axes.grid(visible=False, axis="x")
    axes.set_title("ΔZ, grey: ± 1.96 σ")
    axes.set_ylabel(f"ΔZ [{scale.unit}]")


def check_spline_figure(data: ResultData, spline_id: str) -> str:
    """SVG: distance across at the given points, with the predicted 95 % limit; empty without distances."""
    spline = next(each for each in data["checks"]["splines"] if each["id"] == spline_id)
    distance = np.array(spline["distance"], dtype=float)
    if not np.isfinite(distance).any():
        return ""
    normalized = np.array(spline["normalized"], dtype=float)
    if len(normalized) != len(distance):
        normalized = np.full(len(distance), np.nan)
    scale = length_scale([spline["rms"], spline["sigma_mean"]])
    limit = scale.factor * limits_95(distance, normalized)
    number, tips = np.arange(1, len(distance) + 1), Tips()
    critical = spline.get("critical")
    failed = normalized > (np.inf if critical is None else critical)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.fill_between(number, 0.0, limit, color=MUTED, alpha=0.22, lw=0, label="95 % of good points")
        axes.plot(number, scale.factor * distance, color=ROLE_COLOURS["check"], linewidth=1.0)
        colours = [WARN if each else ROLE_COLOURS["check"] for each in failed]
        known = np.isfinite(distance)
        marks = axes.scatter(
            number[known],
            scale.factor * distance[known],
            s=12,
            c=[colours[i] for i in np.flatnonzero(known)],
            linewidths=0,
        )
        tips.on(
            marks,
            [
                f"given point {number[i]}\ndistance {scale.text(float(distance[i]))}"
                for i in np.flatnonzero(known)
            ],
        )
        axes.set_xlim(0.5, len(distance) + 0.5)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("given point along the spline")
        axes.set_ylabel(f"distance [{scale.unit}]")
        axes.legend(loc="upper right", fontsize=8)

    return svg_of(
        draw, (7.6, 2.3), f"check spline {spline_id}", margins=(0.085, 0.2, 0.985, 0.96, 0.2), tips=tips
    )


def limits_95(distance: FloatArray, normalized: FloatArray) -> FloatArray:
    """Distances that 95 % of good points stay below, in the directions in which the curve was found off, metres.

    With n = √(d′C⁻¹d / 2) the offset d grows by √(χ²₂ / 2) / n until it reaches the ellipse of 95 %.
    """
    factor = np.full(len(distance), np.nan)
    np.divide(np.sqrt(0.5 * _CHI2), normalized, out=factor, where=normalized > 0.0)
    limits: FloatArray = distance * factor
    return limits
