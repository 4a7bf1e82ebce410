"""The figures of the report by name."""

from __future__ import annotations

from collections.abc import Callable

from splinebba_cli.report.blocks import FigureBlock
from splinebba_cli.report.check_figures import check_points_figure, check_spline_figure
from splinebba_cli.report.correlation_figure import correlation_figure
from splinebba_cli.report.format_map import format_map
from splinebba_cli.report.grid_figure import residual_grid
from splinebba_cli.report.plan_figure import block_elevation, block_plan
from splinebba_cli.report.rays_figure import rays_figure
from splinebba_cli.report.redundancy_map import redundancy_map
from splinebba_cli.report.residual_figures import convergence, histogram, image_residuals
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.spline_figure import spline_figure
from splinebba_cli.report.variance_figure import variance_figure
from splinebba_cli.report.vectors_figure import image_vectors

_FIGURES: dict[str, Callable[[ResultData], str]] = {
    "block_plan": block_plan,
    "block_elevation": block_elevation,
    "check_points": check_points_figure,
    "convergence": convergence,
    "correlations": correlation_figure,
    "histogram": histogram,
    "image_residuals": image_residuals,
    "image_vectors": image_vectors,
    "redundancy_map": redundancy_map,
    "variance": variance_figure,
}
_FIGURES_OF: dict[str, Callable[[ResultData, str], str]] = {
    "check_spline": check_spline_figure,
    "format_map": format_map,
    "rays": rays_figure,
    "residual_grid": residual_grid,
    "spline": spline_figure,
}


def draw(block: FigureBlock, data: ResultData) -> str:
    """The markup of a figure, or an empty text where the data do not have it."""
    if block.figure in _FIGURES_OF:
        return _FIGURES_OF[block.figure](data, block.subject)
    return _FIGURES[block.figure](data)
