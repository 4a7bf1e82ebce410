"""What the console says about a pre-analysis: counts, redundancy, predicted σ of orientations, splines, points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.blocks import Column, Table
from splinebba_cli.report.console import rich_table
from splinebba_cli.report.orientation_section import orientation_table
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType


class PredictionSummary:
    """A rich renderable of the content of prediction.json."""

    def __init__(self, content: dict[str, Any]) -> None:
        self._content = content

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Head, what is left out, tables."""
        from rich.text import Text

        content, statistics = self._content, self._content["statistics"]
        yield Text(f"{content['target']}: predicted precision, a priori", style="bold")
        yield Text(
            f"  {statistics['observations']} observations, {statistics['unknowns']} unknowns, "
            f"{statistics['conditions']} conditions, redundancy {statistics['redundancy']}"
        )
        for name in content["left_out"]:
            yield Text(f"  left out, seen by too few images: {name}", style="yellow")
        for problem in content["problems"]:
            yield Text(f"  {problem['severity']}[{problem['code']}] {problem['message']}", style="dim")
        yield Text()
        for table in prediction_tables(content):
            yield from rich_table(table, options.max_width)


def prediction_tables(content: dict[str, Any]) -> tuple[Table, ...]:
    """All tables of a prediction that have rows."""
    orientation = replace(
        orientation_table(ResultData(content)),
        caption="Exterior orientation and predicted standard deviations",
    )
    tables = (_redundancy(content), orientation, _splines(content), _points(content))
    return tuple(table for table in tables if table.rows)


def _redundancy(content: dict[str, Any]) -> Table:
    columns = (
        Column("Observations", numeric=False),
        Column("count"),
        Column("redundancy number", "mean", 3),
        Column("least", decimals=3),
        Column("below 0.1", "%", 1),
    )
    rows = tuple(
        (each["kind"], each["count"], each["mean"], each["smallest"], 100 * each["share_weak"])
        for each in content["redundancy_numbers"]
    )
    return Table("Redundancy numbers", columns, rows, source="prediction.json")


def _splines(content: dict[str, Any]) -> Table:
    splines = content["splines"]
    scale = length_scale([spline["sigma_across"]["mean"] for spline in splines])
    columns = (
        Column("Spline", numeric=False),
        Column("Role", numeric=False),
        Column("Images"),
        Column("Image points"),
        Column("σ across, mean", scale.unit, scale.decimals),
        Column("σ across, max", scale.unit, scale.decimals),
    )
    rows = tuple(
        (
            spline["id"],
            spline["role"],
            spline["images"],
            spline["observations"],
            scale.of(spline["sigma_across"]["mean"]),
            scale.of(spline["sigma_across"]["max"]),
        )
        for spline in splines
    )
    return Table("Splines: predicted precision", columns, rows, source="spline_samples.csv")


def _points(content: dict[str, Any]) -> Table:
    points = content["points"]
    scale = length_scale([point["sigma"][axis] for point in points for axis in "xyz"])
    sigmas = (Column(f"σ {axis}", scale.unit, scale.decimals) for axis in "XYZ")
    columns = (Column("Point", numeric=False), Column("Role", numeric=False), Column("Rays"), *sigmas)
    rows = tuple(
        (point["id"], point["role"], point["rays"], *(scale.of(point["sigma"][axis]) for axis in "xyz"))
        for point in points
    )
    return Table("Points: predicted precision", columns, rows, source="points.csv")
