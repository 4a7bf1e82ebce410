"""What the console says about a campaign: verdict, key figures, tables of orientations, splines, points, starts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.blocks import Cell, Column, Table
from splinebba_cli.report.console import rich_table
from splinebba_cli.report.scale import angle_scale, length_scale

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

_EOP = (("X", "x"), ("Y", "y"), ("Z", "z"), ("ω", "omega"), ("φ", "phi"), ("κ", "kappa"))
_ANGLES = ("omega", "phi", "kappa")


class CampaignSummary:
    """A rich renderable of the content of campaign.json."""

    def __init__(self, content: dict[str, Any]) -> None:
        self._content = content

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Head, failures, tables."""
        from rich.text import Text

        runs = self._content["runs"]
        head = f"{self._content['target']}: {runs['finished']} runs, {runs['solved']} solved"
        yield Text(head, style="bold")
        for reason in runs["reasons"]:
            yield Text(f"  {reason['count']} without a solution: {reason['code']}, {reason['title']}")
        yield Text()
        for table in campaign_tables(self._content):
            yield from rich_table(table, options.max_width)


def campaign_tables(content: dict[str, Any]) -> tuple[Table, ...]:
    """All tables of a campaign that have rows."""
    tables = []
    if content["statistics"] is not None:
        statistics = content["statistics"]
        tables += [figures_table(content), elements_table(statistics), _splines_table(statistics)]
        tables += [locations_table(statistics), _points_table(statistics)]
    tables.append(study_table(content["study"]))
    return tuple(table for table in tables if table.rows)


def figures_table(content: dict[str, Any]) -> Table:
    """Figures of the whole campaign with their intervals."""
    statistics, percent = content["statistics"], f"{100 * content['confidence']:g} %"
    rows: list[tuple[Cell, ...]] = []

    def add(name: str, figure: dict[str, Any] | None) -> None:
        if figure is not None and figure["value"] is not None:
            verdict = "inside" if figure["inside"] else "OUTSIDE"
            rows.append((name, figure["value"], figure["lower"], figure["upper"], verdict))

    add("share of accepted global tests", statistics["acceptance"])
    add("mean squared normalised error of orientations", statistics["mean_square"])
    names = (
        ("eop", "orientations"),
        ("points", "points"),
        ("splines", "splines across"),
        ("locations", "locations along"),
    )
    for kind, name in names:
        if statistics["kinds"][kind] is not None:
            add(f"coverage of {percent} intervals, {name}", statistics["kinds"][kind]["coverage"])
    for kind, name in names:
        if statistics["kinds"][kind] is not None:
            add(f"empirical / predicted σ, smallest, {name}", statistics["kinds"][kind]["smallest_ratio"])
            add(f"empirical / predicted σ, largest, {name}", statistics["kinds"][kind]["largest_ratio"])
    columns = (
        Column("Figure", numeric=False),
        Column("value", decimals=4),
        Column("from", decimals=4),
        Column("to", decimals=4),
        Column("", numeric=False),
    )
    marked = frozenset(i for i, row in enumerate(rows) if row[-1] == "OUTSIDE")
    note = f"intervals of {100 * content['interval']:g} %"
    return Table(f"Figures of the campaign ({note})", columns, tuple(rows), marked)


def elements_table(statistics: dict[str, Any]) -> Table:
    """One row an orientation element, over all images."""
    rows = []
    for symbol, key in _EOP:
        found = [image[key] for image in statistics["images"] if image[key] is not None]
        if not found:
            continue
        sizes = [each["predicted"] for each in found]
        scale = angle_scale(sizes) if key in _ANGLES else length_scale(sizes)
        rows.append((f"{symbol} [{scale.unit}]", *_spread(found, scale.factor)))
    return Table(
        "Orientation elements over all images",
        _spread_columns("Element"),
        tuple(rows),
        source="campaign.json",
    )


def _points_table(statistics: dict[str, Any]) -> Table:
    rows = []
    for key in "xyz":
        found = [point[key] for point in statistics["points"] if point[key] is not None]
        if found:
            scale = length_scale([each["predicted"] for each in found])
            rows.append((f"{key.upper()} [{scale.unit}]", *_spread(found, scale.factor)))
    return Table(
        "Coordinates over all points", _spread_columns("Element"), tuple(rows), source="campaign.json"
    )


def _spread_columns(first: str) -> tuple[Column, ...]:
    return (
        Column(first, numeric=False),
        Column("elements"),
        Column("σ predicted", "rms", 2),
        Column("σ empirical", "rms", 2),
        Column("largest bias", "σ of it", 2),
        Column("ratio", "least", 3),
        Column("ratio", "most", 3),
        Column("coverage", "%", 2),
    )


def _spread(found: list[dict[str, Any]], factor: float) -> tuple[Cell, ...]:
    """Figures of one element over all its images or points."""

    def rms(key: str) -> float:
        return float((sum(each[key] ** 2 for each in found) / len(found)) ** 0.5) * factor

    biases = [abs(each["bias"]) / each["bias_sigma"] for each in found if each["bias_sigma"] > 0.0]
    ratios = [each["ratio"]["value"] for each in found]
    coverage = sum(each["coverage"]["value"] for each in found) / len(found)
    bias = max(biases, default=0.0)
    return len(found), rms("predicted"), rms("empirical"), bias, min(ratios), max(ratios), 100 * coverage


def _splines_table(statistics: dict[str, Any]) -> Table:
    """One row a spline whose shape is estimated."""
    found = [(s["id"], s["across"]) for s in statistics["splines"] if s["across"] is not None]
    scale = length_scale([each["empirical"] for _, each in found])
    bias = length_scale([each["bias_left_sigma"] for _, each in found])
    columns = (
        Column("Spline", numeric=False),
        Column("rms across", scale.unit, scale.decimals),
        Column("bias left", bias.unit, bias.decimals),
        Column("its σ", bias.unit, bias.decimals),
        Column("bias up", bias.unit, bias.decimals),
        Column("its σ", bias.unit, bias.decimals),
        Column("largest bias", "σ of it", 2),
        Column("at", "% of it", 0),
        Column("ratio", decimals=3),
        Column("coverage", "%", 2),
    )
    rows = [
        (
            id,
            scale.of(each["empirical"]),
            *(bias.of(each[f"bias_{name}"]) for name in ("left", "left_sigma", "up", "up_sigma")),
            each["largest_bias_in_sigma"],
            100 * each["largest_bias_place"],
            each["ratio"]["value"],
            100 * each["coverage"]["value"],
        )
        for id, each in found
    ]
    marked = frozenset(
        i
        for i, (_, each) in enumerate(found)
        if not (each["ratio"]["inside"] and each["coverage"]["inside"])
        or each["largest_bias_in_sigma"] > each["largest_bias_limit"]
    )
    return Table("Splines across", columns, tuple(rows), marked, "campaign.json")


def locations_table(statistics: dict[str, Any]) -> Table:
    """One row a spline whose every value is given: the points measured along it."""
    found = [(s["id"], s["locations"]) for s in statistics["splines"] if s["locations"] is not None]
    columns = (
        Column("Spline", numeric=False),
        Column("points"),
        Column("largest bias", "σ of it", 2),
        Column("ratio", "least", 3),
        Column("ratio", "most", 3),
        Column("coverage", "%", 2),
    )
    rows = tuple(
        (
            id, each["elements"], each["largest_bias_in_sigma"], each["smallest_ratio"]["value"],
            each["largest_ratio"]["value"], 100 * each["coverage"]["value"],
        )
        for id, each in found
    )  # fmt: skip
    marked = frozenset(
        i
        for i, (_, each) in enumerate(found)
        if not all(each[key]["inside"] for key in ("coverage", "smallest_ratio", "largest_ratio"))
        or each["largest_bias_in_sigma"] > each["largest_bias_limit"]
    )
    return Table("Locations along given splines", columns, rows, marked, "campaign.json")


def study_table(study: list[dict[str, Any]]) -> Table:
    """Convergence against the size of the initial errors."""
    columns = (
        Column("Factor", decimals=2),
        Column("position", "± m", 2),
        Column("angle", "± °", 3),
        Column("knots", "± m", 2),
        Column("runs"),
        Column("same", "%", 1),
        Column("from", "%", 1),
        Column("to", "%", 1),
        Column("other minimum"),
        Column("failed"),
        Column("iterations", "median", 1),
    )
    rows = [
        (
            each["factor"], each["position_m"], each["angle_deg"], each["knots_m"], each["runs"],
            *(100 * each["same"][key] for key in ("value", "lower", "upper")),
            each["other_minimum"], each["failed"], each["iterations_median"],
        )
        for each in study
    ]  # fmt: skip
    return Table("Convergence from wrong starts", columns, tuple(rows), source="campaign.json")
