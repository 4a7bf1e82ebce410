"""The figures of the report by name."""

from __future__ import annotations

from collections.abc import Callable

from splinebba_cli.report.blocks import FigureBlock
from splinebba_cli.report.grid_figure import residual_grid
from splinebba_cli.report.plan_figure import block_plan
from splinebba_cli.report.residual_figures import convergence, histogram, image_residuals
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.spline_figure import spline_figure

_FIGURES: dict[str, Callable[[ResultData], str]] = {
    "block_plan": block_plan,
    "histogram": histogram,
    "image_residuals": image_residuals,
    "convergence": convergence,
}


def draw(block: FigureBlock, data: ResultData) -> str:
    """The SVG element of a figure, or an empty text where the data do not have it."""
    if block.figure == "spline":
        return spline_figure(data, block.subject)
    if block.figure == "residual_grid":
        return residual_grid(data, block.subject)
    return _FIGURES[block.figure](data)
