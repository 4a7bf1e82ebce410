"""Diagrams of measured times, as SVG: against the number of images, both axes logarithmic."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

from benchmarks.measurements import PLAIN, SPEED, Run, select

Line = tuple[str, str, str, Callable[[Run], float]]

LINES: tuple[Line, ...] = (
    ("Ceres vp, solution", "ceres_vp", "", lambda run: float(run.figures["solve_s"])),
    ("Ceres knots, solution", "ceres_knots", "", lambda run: float(run.figures["solve_s"])),
    ("solution, numpy", "solve", PLAIN, lambda run: statistics.median(run.figures["solve_s"])),
    ("solution, compiled", "solve", SPEED, lambda run: statistics.median(run.figures["solve_s"])),
    ("ceres::Covariance", "ceres_cov", "", lambda run: float(run.figures["cov_s"])),
    ("dispersion", "solve", PLAIN, lambda run: statistics.median(run.figures["dispersion_s"])),
    ("splinebba adjust, numpy", "adjust", PLAIN, lambda run: run.wall_s),
    ("splinebba adjust, compiled", "adjust", SPEED, lambda run: run.wall_s),
    ("Ceres vp, whole process", "ceres_vp", "", lambda run: run.wall_s),
)


def plot_against_peer(runs: Sequence[Run], path: Path) -> None:
    """Median times of both programs by the number of images."""
    figure, axes = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    sizes = sorted({run.size for run in runs})
    for name, task, mode, seconds in LINES:
        found = [
            (images, statistics.median(map(seconds, chosen)))
            for images in sizes
            if (chosen := select(runs, images, task, mode))
        ]
        if found:
            style = "o--" if name.lower().startswith("ceres") else "o-"
            axes.loglog(*zip(*found, strict=True), style, label=name, markersize=4)
    axes.set(xlabel="images", ylabel="seconds (median)")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path)
    plt.close(figure)


def plot_growth(
    panels: Mapping[str, Mapping[str, Sequence[tuple[float, float]]]], xlabel: str, path: Path
) -> None:
    """One panel for each quantity (its name is the label of the axis), one line for each series of (size, value)."""
    figure, grid = plt.subplots(
        1, len(panels), figsize=(5.0 * len(panels), 4.0), layout="constrained", squeeze=False
    )
    for axes, (label, lines) in zip(grid[0], panels.items(), strict=True):
        _draw(axes, lines)
        axes.set(xlabel=xlabel, ylabel=label)
    figure.savefig(path)
    plt.close(figure)


def _draw(axes: Any, lines: Mapping[str, Sequence[tuple[float, float]]]) -> None:
    for name, line in lines.items():
        if line:
            axes.loglog(*zip(*line, strict=True), "o-", label=name, markersize=4)
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(fontsize=8)
