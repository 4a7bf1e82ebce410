"""Splines fitted to digitised points: plan with points and knots, and the distances along the curves."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.curves.fitting import FittedSpline
from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.scale import round_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = ("svg", "png", "pdf")
_CURVE, _POINTS, _KNOTS, _LIMIT = "#1f5fa8", "#9a9a9a", "#101112", "#b3261e"
_SAMPLES_PER_SEGMENT, _LABELLED = 24, 20
_STYLE: Any = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#d0d1d2",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "text.parse_math": False,
    "svg.hashsalt": "splinebba fit",
    "path.simplify": True,
}


def fit_figure(splines: Sequence[tuple[str, FittedSpline]], format: str) -> bytes:
    """The figure as a file; the same splines give the same bytes.

    Parameters
    ----------
    splines : sequence of (id, spline)
    format : one of :data:`FORMATS`
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        figure = Figure(figsize=(8.0, 7.0), layout="constrained", dpi=150)
        plan, distances = figure.subplots(2, 1, height_ratios=(2.2, 1.0))
        _draw_plan(plan, splines)
        _draw_distances(distances, splines)
        stream = io.BytesIO()
        metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}[format]
        figure.savefig(stream, format=format, metadata=metadata)
    return stream.getvalue()


def sampled(spline: FittedSpline) -> FloatArray:
    """Points along the curve, (m, 3) metres."""
    breaks = spline.knot_parameters
    steps = np.arange(_SAMPLES_PER_SEGMENT) / _SAMPLES_PER_SEGMENT
    u = (breaks[:-1, None] + steps * np.diff(breaks)[:, None]).ravel()
    xyz = spline.evaluate(np.append(u, breaks[-1]))
    return np.vstack([xyz[:-1], xyz[:1]]) if spline.closed else xyz


def _draw_plan(axes: Axes, splines: Sequence[tuple[str, FittedSpline]]) -> None:
    origin = _round_origin(splines)
    axes.set_aspect("equal", adjustable="datalim")
    for number, (id, spline) in enumerate(splines):
        curve, points, knots = (v[:, :2] - origin for v in (sampled(spline), spline.points, spline.knots))
        labels = ("digitised points", "spline", "knots") if number == 0 else ("", "", "")
        axes.plot(points[:, 0], points[:, 1], ".", color=_POINTS, markersize=3, label=labels[0])
        axes.plot(curve[:, 0], curve[:, 1], color=_CURVE, linewidth=1.2, label=labels[1])
        axes.plot(knots[:, 0], knots[:, 1], "o", color=_KNOTS, markersize=3, label=labels[2])
        if len(splines) <= _LABELLED:
            middle = knots[len(knots) // 2]
            axes.annotate(id, middle, xytext=(5, 5), textcoords="offset points", fontsize=7.5, color=_CURVE)
    axes.set_xlabel(f"X − {origin[0]:.0f} [m]" if origin[0] else "X [m]")
    axes.set_ylabel(f"Y − {origin[1]:.0f} [m]" if origin[1] else "Y [m]")
    axes.legend(loc="best")


def _round_origin(splines: Sequence[tuple[str, FittedSpline]]) -> FloatArray:
    """What is taken off large coordinates so that the axes stay readable, (2,) metres."""
    lower = np.min([spline.points[:, :2].min(axis=0) for _, spline in splines], axis=0)
    upper = np.max([spline.points[:, :2].max(axis=0) for _, spline in splines], axis=0)
    step = round_length(float((upper - lower).max()))
    far = np.abs(lower) > 10.0 * (upper - lower).max()
    return np.where(far, np.floor(lower / max(step, 1.0)) * max(step, 1.0), 0.0)


def _draw_distances(axes: Axes, splines: Sequence[tuple[str, FittedSpline]]) -> None:
    threshold = max(spline.threshold_m for _, spline in splines)
    factor, unit = (1000.0, "mm") if threshold < 1.0 else (1.0, "m")
    for number, (_, spline) in enumerate(splines):
        steps = np.linalg.norm(np.diff(spline.points, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        label = "distance of the points" if number == 0 else ""
        axes.plot(along, factor * spline.distance, ".", color=_CURVE, markersize=2, label=label)
        chosen = np.interp(spline.knot_parameters[: len(spline.knots)], spline.location, along)
        axes.plot(
            chosen, np.zeros(len(chosen)), "|", color=_KNOTS, markersize=7, label="" if number else "knots"
        )
    axes.axhline(factor * threshold, color=_LIMIT, linewidth=1.0, label="threshold")
    axes.set_ylim(0.0, 1.3 * factor * threshold)
    axes.set_xlabel("distance along the points [m]")
    axes.set_ylabel(f"distance from the curve [{unit}]")
    axes.legend(loc="upper right", ncols=3)
