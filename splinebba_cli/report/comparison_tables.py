"""A comparison of two results for the console: what they are, how they are related, what differs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.blocks import Cell, Column, Table
from splinebba_cli.report.console import rich_table
from splinebba_cli.report.scale import angle_scale, length_scale

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

_ANGLES = (("ω", "omega"), ("φ", "phi"), ("κ", "kappa"))
_STATISTICS = (
    ("Observations", "observations"),
    ("Unknowns", "unknowns"),
    ("Gauge and datum conditions", "conditions"),
    ("Redundancy", "redundancy"),
    ("v′Pv", "vtpv"),
    ("σ₀ a priori", "sigma0_prior"),
    ("σ̂₀ a posteriori", "sigma0"),
    ("Global test", "global_test_passed"),
    ("Datum", "datum"),
    ("Program", "program"),
)


class ComparisonText:
    """A rich renderable of a comparison.

    Parameters
    ----------
    data : dict
        From :func:`splinebba_cli.output.comparison_json.comparison_to_dict`.
    """

    def __init__(self, data: dict[str, Any]) -> None:
        self._data = data

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Verdict, relation, statistics, tests, differences."""
        from rich.text import Text

        data, relation = self._data, self._data["relation"]
        yield Text(*_verdict(data))
        yield Text(f"A: {data['results']['a']['folder']}\nB: {data['results']['b']['folder']}")
        yield Text(f"Relation: {relation['name']} ({relation['reason']}).\n{relation['explanation']}.")
        for problem in data["problems"]:
            yield Text(f"{problem['severity']}[{problem['code']}] {problem['message']}", style="yellow")
        yield Text()
        for sentence in sentences(data):
            yield Text(sentence)
        yield Text()
        for table in comparison_tables(data):
            if table.rows:
                yield from rich_table(table, options.max_width)


def _verdict(data: dict[str, Any]) -> tuple[str, str]:
    if data["significant"]:
        return f"The results differ significantly (α = {data['alpha']:g})", "bold yellow"
    tested = data["variance_test"] or data["model_test"]
    tested = tested or any(
        d["dimensions"] for kind in ("images", "points") for d in data[kind]["differences"]
    )
    if not tested:
        title = (
            "Images and points are the same" if _same(data) else "The results are compared, but not tested"
        )
        return title, "bold"
    return f"The results do not differ significantly (α = {data['alpha']:g})", "bold green"


def _same(data: dict[str, Any]) -> bool:
    """Whether all images and points are in both and not one figure of theirs differs."""
    parts = [data[kind] for kind in ("images", "points")]
    differences = [each[name] for part in parts for each in part["differences"] for name in each["sigma"]]
    return not any(differences) and not any(part["only_a"] or part["only_b"] for part in parts)


def sentences(data: dict[str, Any]) -> list[str]:
    """The tests of the whole, one sentence each."""
    found = []
    test = data["variance_test"]
    if test is not None:
        found.append(
            f"Variances of unit weight: σ̂²_A/σ̂²_B = {test['statistic']:.4f}, accepted from {test['lower']:.4f} to "
            f"{test['upper']:.4f} (F of {_degrees(test)}): {_outcome(test)}."
        )
    test = data["model_test"]
    if test is not None:
        kind = "χ²" if test["degrees"][1] is None else "F"
        found.append(
            f"The {test['degrees'][0]:.0f} additional parameters: {kind} = {test['statistic']:.3f}, largest accepted "
            f"{test['upper']:.3f} (degrees of freedom {_degrees(test)}): {_outcome(test)}."
        )
    similarity = data["similarity"]
    if similarity is not None:
        shift = ", ".join(f"{value:+.4f}" for value in similarity["translation_m"])
        angles = ", ".join(f"{value:+.6f}" for value in similarity["rotation_deg"])
        found.append(
            f"B was transformed onto A by a similarity over {similarity['points']} positions: shift {shift} m, "
            f"rotation {angles}°, scale {similarity['scale_ppm']:+.2f} ppm; RMS left {similarity['rms_m']:.4g} m."
        )
    for kind in ("images", "points"):
        one = data[kind]
        if one["only_a"] or one["only_b"]:
            found.append(f"{len(one['only_a'])} {kind} only in A, {len(one['only_b'])} only in B.")
    return found


def _degrees(test: dict[str, Any]) -> str:
    first, second = test["degrees"]
    return f"{first:.0f}" if second is None else f"{first:.0f}, {second:.0f}"


def _outcome(test: dict[str, Any]) -> str:
    word = "significant" if test["significant"] else "not significant"
    return f"p = {test['probability']:.3g}, {word}"


def comparison_tables(data: dict[str, Any]) -> list[Table]:
    """Statistics, inputs, images, points, splines."""
    return [_statistics(data), _inputs(data), _images(data), _points(data), _splines(data)]


def _statistics(data: dict[str, Any]) -> Table:
    a, b = data["results"]["a"], data["results"]["b"]
    rows = tuple((title, _cell(a[key]), _cell(b[key])) for title, key in _STATISTICS)
    columns = (Column("", numeric=False), Column("A"), Column("B"))
    return Table("Statistics", columns, rows, frozenset(k for k, row in enumerate(rows) if row[1] != row[2]))


def _cell(value: Any) -> Cell:
    if isinstance(value, bool):
        return "passed" if value else "failed"
    return f"{value:.6g}" if isinstance(value, float) else value


def _inputs(data: dict[str, Any]) -> Table:
    rows = tuple((item["file"], item["status"]) for item in data["inputs"])
    marks = frozenset(k for k, row in enumerate(rows) if row[1] != "same")
    return Table("Input files", (Column("File", numeric=False), Column("Status", numeric=False)), rows, marks)


def _images(data: dict[str, Any]) -> Table:
    items = data["images"]["differences"]
    length = length_scale(item[axis] for item in items for axis in "xyz")
    angle = angle_scale(item[key] for item in items for _, key in _ANGLES)
    columns = [Column("Image", numeric=False), *_test_columns()]
    columns += [Column(f"Δ{axis.upper()}", length.unit, length.decimals) for axis in "xyz"]
    columns += [Column(f"Δ{symbol}", angle.unit, angle.decimals) for symbol, _ in _ANGLES]
    columns += [Column(f"Δ{axis.upper()}/σ", "", 2) for axis in "xyz"]
    columns += [Column(f"Δ{symbol}/σ", "", 2) for symbol, _ in _ANGLES]
    rows = []
    for item in items:
        row: list[Cell] = [item["id"], *_test_cells(item)]
        row += [length.of(item[axis]) for axis in "xyz"] + [angle.of(item[key]) for _, key in _ANGLES]
        row += [item["standardized"][axis] for axis in "xyz"]
        row += [item["standardized"][key] for _, key in _ANGLES]
        rows.append(tuple(row))
    return Table("Images, A − B", tuple(columns), tuple(rows), _marks(items), "--format json")


def _points(data: dict[str, Any]) -> Table:
    items = data["points"]["differences"]
    length = length_scale(item[axis] for item in items for axis in "xyz")
    columns = [Column("Point", numeric=False), *_test_columns()]
    columns += [Column(f"Δ{axis.upper()}", length.unit, length.decimals) for axis in "xyz"]
    columns += [Column(f"Δ{axis.upper()}/σ", "", 2) for axis in "xyz"]
    rows = tuple(
        (
            item["id"],
            *_test_cells(item),
            *(length.of(item[axis]) for axis in "xyz"),
            *(item["standardized"][axis] for axis in "xyz"),
        )
        for item in items
    )
    return Table("Points, A − B", tuple(columns), rows, _marks(items), "--format json")


def _splines(data: dict[str, Any]) -> Table:
    items = data["splines"]
    length = length_scale(item["rms_m"] for item in items)
    columns = [Column("Spline", numeric=False), Column("Samples"), Column("p", "", 4)]
    columns += [Column(title, length.unit, length.decimals) for title in ("RMS across", "Largest", "σ")]
    columns.append(Column("Largest normalised", "", 2))
    rows = tuple(
        (
            item["id"],
            item["samples"],
            item["probability"],
            *(length.of(item[key]) for key in ("rms_m", "max_m", "sigma_m")),
            item["normalized_max"],
        )
        for item in items
    )
    return Table(
        "Splines, distance across at the samples of A", tuple(columns), rows, _marks(items), "--format json"
    )


def _test_columns() -> list[Column]:
    return [Column("d′C⁻¹d", "", 2), Column("f"), Column("p", "", 4)]


def _test_cells(item: dict[str, Any]) -> tuple[Cell, ...]:
    return item["statistic"], item["dimensions"], item["probability"]


def _marks(items: list[dict[str, Any]]) -> frozenset[int]:
    return frozenset(k for k, item in enumerate(items) if item["significant"])
