"""Figures of a campaign as SVG or PNG: coverage, ratios, global test, normalised errors, convergence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.report.canvas import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"eop": "#33658a", "points": "#8a5a33", "splines": "#3a7d44", "locations": "#7a4b94"}
_NAMES = {
    "eop": "orientations",
    "points": "points",
    "splines": "splines across",
    "locations": "locations along",
}
_INK, _BAND = "#202428", "#c8ced4"


def write_campaign_figures(content: dict[str, Any], folder: Path, suffix: str) -> list[Path]:
    """Draw the figures of a campaign that it has data for.

    Parameters
    ----------
    content : of campaign.json
    suffix : "svg" or "png"
    """
    drawn: list[tuple[str, Callable[[Figure], None], tuple[float, float]]] = []
    statistics = content["statistics"]
    if statistics is not None:
        drawn += [
            ("coverage", lambda figure: _coverage(figure, content), (7.6, 3.4)),
            ("ratios", lambda figure: _ratios(figure, statistics), (7.6, 3.4)),
            ("normalized_errors", lambda figure: _histogram(figure, statistics), (7.6, 3.0)),
        ]
        if statistics["acceptance"] is not None:
            drawn.append(("global_test", lambda figure: _acceptance(figure, statistics), (7.6, 1.5)))
    if content["study"]:
        drawn.append(("convergence", lambda figure: _convergence(figure, content["study"]), (7.6, 3.2)))
    return [write_figure(draw, size, folder / f"{name}.{suffix}") for name, draw, size in drawn]


def _items(statistics: dict[str, Any], key: str) -> list[tuple[str, float, float, float]]:
    """Kind, value, lower and upper of a figure for every element, point and spline, in their order.

    Locations are drawn spline by spline: pooled coverage, smallest and largest ratio.
    """
    figures = [("eop", value[key]) for image in statistics["images"] for value in _elements(image)]
    figures += [("points", value[key]) for point in statistics["points"] for value in _elements(point)]
    splines = statistics["splines"]
    figures += [("splines", spline["across"][key]) for spline in splines if spline["across"]]
    pooled = ("smallest_ratio", "largest_ratio") if key == "ratio" else (key,)
    for spline in splines:
        if spline["locations"]:
            figures += [("locations", spline["locations"][name]) for name in pooled]
    return [
        (kind, each["value"], each["lower"], each["upper"])
        for kind, each in figures
        if each["value"] is not None
    ]


def _elements(item: dict[str, Any]) -> list[dict[str, Any]]:
    return [value for value in item.values() if isinstance(value, dict)]


def _with_intervals(axes: Axes, items: list[tuple[str, float, float, float]]) -> None:
    number = np.arange(len(items))
    lower, upper = (np.array([item[i] for item in items]) for i in (2, 3))
    axes.vlines(number, lower, upper, color=_BAND, linewidth=min(6.0, 300.0 / max(len(items), 1)))
    for kind, colour in _COLOURS.items():
        chosen = [i for i, item in enumerate(items) if item[0] == kind]
        if chosen:
            values = [items[i][1] for i in chosen]
            axes.plot(chosen, values, "o", color=colour, markersize=3, label=_NAMES[kind])
    axes.set_xticks([])
    axes.set_xlim(-1.0, len(items))
    axes.legend(loc="lower right", fontsize=8, ncols=3)


def _coverage(figure: Figure, content: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    _with_intervals(axes, _items(content["statistics"], "coverage"))
    axes.axhline(content["confidence"], color=_INK, linewidth=0.8)
    axes.set_ylabel(f"coverage of {100 * content['confidence']:g} % intervals")
    axes.set_xlabel("elements of all images, points, splines; bars: 99 % intervals")


def _ratios(figure: Figure, statistics: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    _with_intervals(axes, _items(statistics, "ratio"))
    axes.axhline(1.0, color=_INK, linewidth=0.8)
    axes.set_ylabel("empirical / predicted σ")
    axes.set_xlabel("elements of all images, points, splines; bars: 99 % intervals of each")


def _histogram(figure: Figure, statistics: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    edges = np.array(statistics["histogram"]["edges"])
    for kind, colour in _COLOURS.items():
        counts = np.array(statistics["histogram"][kind], dtype=float)
        if counts.sum() > 0.0:
            density = counts / (counts.sum() * np.diff(edges))
            axes.stairs(density, edges, color=colour, label=f"{_NAMES[kind]}: {int(counts.sum())} values")
    grid = np.linspace(edges[0], edges[-1], 201)
    axes.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2 * np.pi), color=_INK, label="N(0, 1)")
    axes.set_xlabel("error over predicted σ; values beyond the ends are in the last bins")
    axes.set_ylabel("density")
    axes.legend(loc="upper right", fontsize=8)


def _acceptance(figure: Figure, statistics: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    value = statistics["acceptance"]
    axes.hlines(0.0, value["lower"], value["upper"], color=_BAND, linewidth=10)
    axes.plot([value["value"]], [0.0], "o", color=_COLOURS["eop"])
    axes.axvline(1.0 - statistics["alpha"], color=_INK, linewidth=0.8)
    axes.set_yticks([])
    axes.set_xlabel("share of accepted global tests; bar: 99 % interval")


def _convergence(figure: Figure, study: list[dict[str, Any]]) -> None:
    axes = figure.add_subplot()
    factor = np.array([each["factor"] for each in study])
    value, lower, upper = (
        np.array([each["same"][key] for each in study]) for key in ("value", "lower", "upper")
    )
    axes.fill_between(factor, lower, upper, color=_BAND, label="99 % interval")
    axes.plot(factor, value, "o-", color=_COLOURS["eop"], markersize=3, label="same solution")
    failed = np.array([each["failed"] / each["runs"] for each in study])
    other = np.array([each["other_minimum"] / each["runs"] for each in study])
    axes.plot(factor, failed, ".--", color="#a33b3b", label="failed")
    axes.plot(factor, other, ".:", color="#8a5a33", label="other minimum")
    axes.set_ylim(-0.03, 1.03)
    axes.set_ylabel("share of the runs")
    axes.set_xlabel(f"size of the initial errors; 1 is {_size(study)}")
    axes.legend(loc="center right", fontsize=8)


def _size(study: list[dict[str, Any]]) -> str:
    """The errors of factor 1 in words."""
    each = next((item for item in study if item["factor"] > 0.0), None)
    if each is None:
        return "not swept"
    units = (("position_m", "m"), ("angle_deg", "°"), ("knots_m", "m (knots)"))
    parts = [f"± {each[key] / each['factor']:.3g} {unit}" for key, unit in units if each[key] is not None]
    return ", ".join(parts)
