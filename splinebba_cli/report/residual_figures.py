"""Histogram of standardized residuals, residuals per image, convergence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.report.canvas import INK, ROLE_COLOURS, STATION, svg_of
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.stage_marks import mark_stages
from splinebba_cli.report.svg_text import Tips, visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LIMIT = 5.0
_TAIL = 60  # values that are drawn one by one at either end of a distribution
_LABELLED_BARS, _CHARACTERS = 60, 80
_BARS = 480.0  # points, width of the plot
_SERIES = (("points", STATION), ("splines", ROLE_COLOURS["tie"]))


def histogram(data: ResultData) -> str:
    """SVG: standardized residuals of points and splines against N(0, 1), as histogram and quantile by quantile."""
    series = standardized(data)

    def draw(figure: Figure) -> None:
        bars, quantiles = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        _draw_histogram(bars, series)
        _draw_quantiles(quantiles, series)

    return svg_of(draw, (7.6, 3.1), "histogram", margins=(0.075, 0.15, 0.985, 0.975, 0.2))


def standardized(data: ResultData) -> dict[str, FloatArray]:
    """All standardized residuals of points and splines."""
    table = data.residuals
    x, y, across = (table.numbers(f"standardized_{name}") for name in ("x", "y", "across"))
    series = {"points": np.concatenate([x, y]), "splines": across}
    return {name: values[np.isfinite(values)] for name, values in series.items()}


def _draw_histogram(axes: Axes, series: dict[str, FloatArray]) -> None:
    bins = np.linspace(-_LIMIT, _LIMIT, 41).tolist()
    for name, colour in _SERIES:
        values = series[name]
        if len(values):
            label = f"{name}: {len(values)}, rms {np.sqrt(np.mean(values**2)):.2f}"
            shown = np.clip(values, -_LIMIT + 1e-9, _LIMIT - 1e-9)
            axes.hist(shown, bins, density=True, histtype="stepfilled", color=colour, alpha=0.30, label=label)
            axes.hist(shown, bins, density=True, histtype="step", color=colour, linewidth=1.1)
    grid = np.linspace(-_LIMIT, _LIMIT, 201)
    axes.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2 * np.pi), color=INK, label="N(0, 1)")
    axes.set_xlim(-_LIMIT, _LIMIT)
    axes.set_ylim(top=1.32 * axes.get_ylim()[1])
    axes.set_xlabel(f"standardized residual w; beyond ±{_LIMIT:g}: last bins")
    axes.set_ylabel("density")
    axes.legend(loc="upper left", fontsize=7.5, ncols=2)


def _draw_quantiles(axes: Axes, series: dict[str, FloatArray]) -> None:
    """Sorted values over the quantiles of N(0, 1): on the line where they are normal."""
    from scipy.special import ndtri

    axes.plot([-_LIMIT, _LIMIT], [-_LIMIT, _LIMIT], color=INK, linewidth=1.0)
    reach = 1.0
    for name, colour in _SERIES:
        values = np.sort(series[name])
        if len(values):
            chosen = _spread(len(values))
            normal = ndtri((chosen + 0.5) / len(values))
            axes.plot(normal, values[chosen], ".", color=colour, markersize=3.5, label=name)
            reach = max(reach, float(np.abs(values).max()), float(np.abs(normal).max()))
    reach = 1.06 * min(reach, 2.0 * _LIMIT)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("quantile of N(0, 1)")
    axes.set_ylabel("w, sorted")


def _spread(count: int) -> IntArray:
    """Numbers of sorted values that are drawn: all at both ends, evenly spread between."""
    if count <= 3 * _TAIL:
        return np.arange(count)
    middle = np.linspace(_TAIL, count - 1 - _TAIL, _TAIL).round().astype(np.int64)
    return np.unique(np.concatenate([np.arange(_TAIL), middle, np.arange(count - _TAIL, count)]))


def image_residuals(data: ResultData) -> str:
    """SVG: rms residual of every image, in pixels where the pixel size is known, else in micrometres."""
    images = data["residuals"]["images"]
    pixels = all(
        image[group]["n"] == 0 or image[group]["rms_px"] is not None
        for image in images
        for group, _ in _SERIES
    )
    values = {group: _rms(images, group, pixels) for group, _ in _SERIES}
    present = [(group, colour) for group, colour in _SERIES if np.isfinite(values[group]).any()]
    few = len(images) <= _LABELLED_BARS
    tips, unit = Tips(), "px" if pixels else "µm"
    says = {
        group: [
            f"image {image['id']}, {group}: {image[group]['n']}\nrms {value:.3g} {unit}"
            for image, value in zip(images, values[group], strict=True)
        ]
        for group, _ in present
    }

    def draw(figure: Figure) -> None:
        from matplotlib.patches import Patch

        axes = figure.add_subplot()
        width, spare = 0.8 / max(len(present), 1), 0.5 * max(8 - len(images), 0)
        for number, (group, colour) in enumerate(present):
            if few:
                position = np.arange(len(images)) - 0.4 + (number + 0.5) * width
                bars = axes.vlines(position, 0.0, np.nan_to_num(values[group]), color=colour, alpha=0.8)
                bars.set_linewidth(_BARS * width / (len(images) + 2.0 * spare))
                tips.on(bars, says[group])
            else:
                known = np.flatnonzero(np.isfinite(values[group]))
                (marks,) = axes.plot(known, values[group][known], ".", color=colour, markersize=3)
                tips.on(marks, [says[group][k] for k in known])
        if few:
            names = [visible(image["id"], 16) for image in images]
            long = max(map(len, names)) * len(names) > _CHARACTERS
            axes.set_xticks(np.arange(len(images)), names, rotation=90 if long else 0)
            axes.set_ylim(bottom=0.0)
        else:
            axes.set_xlabel("number of the image in the table")
            axes.set_ylim(bottom=0.0)
        axes.set_xlim(-0.6 - spare, len(images) - 0.4 + spare)
        axes.grid(visible=False, axis="x")
        axes.set_ylabel(f"rms residual [{unit}]")
        patches = [Patch(color=colour, alpha=0.8, label=group) for group, colour in present]
        figure.legend(handles=patches, loc="outside upper right", ncols=2, fontsize=8)

    return svg_of(draw, (7.6, 2.7), "image_residuals", tips=tips)


def _rms(images: list[dict[str, Any]], group: str, pixels: bool) -> FloatArray:
    key, factor = ("rms_px", 1.0) if pixels else ("rms_mm", 1e3)
    return factor * np.array([image[group][key] for image in images], dtype=float)


def convergence(data: ResultData) -> str:
    """SVG: cost and largest step of every iteration."""
    log = data["convergence"]
    number = np.arange(1, len(log) + 1)
    cost = np.array([line["cost"] for line in log], dtype=float)
    step = np.array([line["step"] for line in log], dtype=float)
    stages = [line["stage"] for line in log]

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        for axes, values, title in ((left, cost, "v′Pv"), (right, step, "Largest step [σ]")):
            positive = np.where(values > 0, values, np.nan)
            axes.plot(number, positive, "o-", color=STATION, markersize=3)
            if np.isfinite(positive).any():
                axes.set_yscale("log")
                axes.yaxis.set_major_formatter("{x:g}")
                axes.yaxis.set_minor_formatter("")
            axes.set_title(title)
            axes.set_xlabel("iteration")
            mark_stages(axes, stages)

    return svg_of(draw, (7.6, 2.7), "convergence", margins=(0.1, 0.17, 0.985, 0.89, 0.26))
