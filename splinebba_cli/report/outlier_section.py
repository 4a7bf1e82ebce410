"""Which observations were rejected, reweighted or excluded, and why."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Fact, Facts, Note, Section, Table
from splinebba_cli.report.result_data import ResultData

_SHOWN = 40
_METHODS = {
    "none": "none",
    "snooping": "iterative data snooping",
    "huber": "reweighted adjustment, Huber",
    "cauchy": "reweighted adjustment, Cauchy",
    "tukey": "reweighted adjustment, Tukey (biweight)",
    "danish": "reweighted adjustment, Danish method",
}
_READING = (
    "The weights are those of the last round; σ̂₀, redundancy numbers and w belong to them. Down-weighting makes σ̂₀ "
    "smaller than the noise of all observations together: the global test is no test of the model here."
)


def outliers_section(data: ResultData) -> Section:
    """Counts and the log of the search for outliers; nothing where nothing was sought or taken out."""
    revision: dict[str, Any] = data.content.get("revision") or {}
    excluded = revision.get("excluded_by_user", 0)
    if not revision or (revision["method"] == "none" and not excluded and not revision["rejections"]):
        return Section("outliers", "Outliers", ())
    start = "high-breakdown start" if revision["start"] == "high_breakdown" else "least squares"
    items = [
        Fact("Method", _METHODS[revision["method"]], f"start: {start}; {revision['rounds']} rounds"),
        Fact("Observations used", f"{revision['used']}"),
        Fact("Rejected", f"{revision['rejected']}", "", "warning" if revision["rejected"] else "good"),
    ]
    if revision["reweighted"]:
        items.append(Fact("With less than full weight", f"{revision['reweighted']}"))
    if excluded:
        items.append(Fact("Excluded by the user", f"{excluded}", "column `use` of the observation tables"))
    blocks: list[Block] = [Facts(tuple(items))]
    if revision["reweighted"]:
        blocks.append(Note(_READING))
    if revision["rejections"]:
        blocks.append(_log_table(revision["rejections"]))
    return Section("outliers", "Outliers", tuple(blocks))


def _log_table(log: list[dict[str, Any]]) -> Table:
    """What is rejected now comes first, the worst on top; what has returned follows."""
    order = sorted(log, key=lambda each: (each["returned"], -abs(each["predicted_w"] or 0.0)))
    columns = (
        Column("Observation", numeric=False),
        Column("Row", help="number of the observation among those of its kind, in the order of the project"),
        Column("Round"),
        Column("Reason", numeric=False),
        Column("Predicted v", numeric=False),
        Column("Predicted w", "", 2),
        Column("Now", numeric=False),
    )
    rows: list[tuple[Cell, ...]] = [
        (
            each["name"].replace("`", ""),
            each["row"],
            each["round"],
            each["reason"],
            _residual(each),
            each["predicted_w"],
            "used again" if each["returned"] else "rejected",
        )
        for each in order[:_SHOWN]
    ]
    more = f"{len(log) - _SHOWN} further decisions are in rejections.csv. " if len(log) > _SHOWN else ""
    note = (
        f"{more}Predicted: residual (adjusted − measured) and w against the last solution, in which the observation "
        "took no part. To bring one back, change its `use` in the tables of adjusted.yaml."
    )
    marked = frozenset(k for k, each in enumerate(order[:_SHOWN]) if not each["returned"])
    return Table("Decisions", columns, tuple(rows), marked, "rejections.csv", note=note)


def _residual(entry: dict[str, Any]) -> str:
    value = entry["predicted_residual"]
    if value is None:
        return "–"
    return f"{value:.3f}°" if entry["kind"] == "tangent" else f"{1e3 * value:.2f} µm"
