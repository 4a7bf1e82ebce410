"""Acceptance criteria; check points and check splines with their tests."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Fact, Facts, Note, Section, Table, Tone
from splinebba_cli.report.figure_blocks import check_point_blocks, check_spline_blocks
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale

_MARKS = {"passed": "passed", "failed": "FAILED", "untested": "NOT TESTED"}


def acceptance_section(data: ResultData) -> Section:
    """Every criterion of the project with what was found; empty where the project has none."""
    criteria = data.content.get("acceptance") or []
    if not criteria:
        return Section("acceptance", "Acceptance", ())
    rows: list[tuple[Cell, ...]] = []
    for each in criteria:
        unit = f" {each['unit']}" if each["unit"] else ""
        value = "–" if each["value"] is None else f"{each['value']:.4g}{unit}"
        limit = "test" if each["limit"] is None else f"{_sign(each['criterion'])} {each['limit']:g}{unit}"
        rows.append((each["title"], value, limit, _MARKS[each["status"]], each["subject"].replace("`", "")))
    passed = sum(each["status"] == "passed" for each in criteria)
    tone: Tone = "good" if passed == len(criteria) else "bad"
    columns = (
        Column("Criterion", numeric=False),
        Column("Found"),
        Column("Allowed"),
        Column("Status", numeric=False),
        Column("Worst", numeric=False),
    )
    marks = frozenset(k for k, each in enumerate(criteria) if each["status"] != "passed")
    note = "A criterion that cannot be tested is not satisfied." if "untested" in _states(criteria) else ""
    facts = Facts((Fact("Criteria satisfied", f"{passed} of {len(criteria)}", tone=tone),))
    table = Table("Acceptance criteria of the project", columns, tuple(rows), marks, "result.json", note=note)
    return Section("acceptance", "Acceptance", (facts, table))


def _sign(key: str) -> str:
    return "≥" if key.startswith("min_") else "≤"


def _states(criteria: list[dict[str, Any]]) -> set[str]:
    return {each["status"] for each in criteria}


def checks_section(data: ResultData) -> Section:
    """Differences at check points and check splines."""
    checks = data["checks"]
    blocks: list[Block] = []
    if checks["points"]:
        blocks += check_point_blocks(checks)
        blocks += _points(checks)
    if checks["splines"]:
        blocks += _splines(checks["splines"])
        blocks += check_spline_blocks(checks["splines"])
    return Section("checks", "Checks", tuple(blocks))


def _points(checks: dict[str, Any]) -> list[Block]:
    scale = length_scale(point["difference"][axis] for point in checks["points"] for axis in "xyz")
    columns = [Column("Point", numeric=False)]
    columns += [Column(f"Δ{axis}", scale.unit, scale.decimals) for axis in "XYZ"]
    columns += [Column(f"σ Δ{axis}", scale.unit, scale.decimals) for axis in "XYZ"]
    columns.append(Column("normalized", "", 2, help="√(d′Q⁻¹d / 3); about 1 where the predicted σ is right"))
    rows = tuple(
        (
            point["id"],
            *(scale.of(point["difference"][axis]) for axis in "xyz"),
            *(scale.of(point["sigma"][axis]) for axis in "xyz"),
            point["normalized"],
        )
        for point in checks["points"]
    )
    marks = frozenset(i for i, point in enumerate(checks["points"]) if not point.get("passed", True))
    summary = checks.get("points_summary")
    table = Table("Check points: adjusted − given", tuple(columns), rows, marks, "result.json")
    if summary is None:
        rms = checks["points_rms"]
        return [Facts(tuple(Fact(f"RMS Δ{axis.upper()}", scale.text(rms[axis])) for axis in "xyz")), table]
    return [_accuracy(summary), Facts(_tests(summary)), _by_coordinate(summary), table]


def _accuracy(summary: dict[str, Any]) -> Facts:
    rmse, given, accuracy = summary["rmse"], summary["given"], summary["accuracy"]
    scale = length_scale([rmse["horizontal"], rmse["vertical"]])
    about = "√(RMSE² + accuracy of the given coordinates²), ASPRS 2023"
    return Facts(
        (
            Fact("RMSE horizontal", scale.text(rmse["horizontal"]), f"{summary['count']} check points"),
            Fact("RMSE vertical", scale.text(rmse["vertical"])),
            Fact(
                "Accuracy of the given coordinates",
                f"{scale.text(given['horizontal'])} horizontal, {scale.text(given['vertical'])} vertical",
            ),
            Fact("Horizontal positional accuracy", scale.text(accuracy["horizontal"]), about),
            Fact("Vertical positional accuracy", scale.text(accuracy["vertical"]), about),
            Fact(
                "3D positional accuracy", scale.text(accuracy["3d"]), "√(horizontal² + vertical²), ASPRS 2023"
            ),
        )
    )


def _tests(summary: dict[str, Any]) -> tuple[Fact, ...]:
    beyond, count = summary["beyond"], summary["count"]
    single = f"√(d′Q⁻¹d / 3) up to {summary['critical']:.2f}, α = {summary['alpha']:g} for all of them"
    facts = [
        Fact("Single points", f"{count - beyond} of {count} agree", single, "warning" if beyond else "good")
    ]
    for key, title in (("together", "All points together"), ("shift", "Mean difference (systematic shift)")):
        test = summary[key]
        if test is not None:
            facts.append(_test_fact(title, test))
    return tuple(facts)


def _test_fact(title: str, test: dict[str, Any]) -> Fact:
    note = f"largest accepted {test['critical']:.2f}, {test['degrees']:.3g} degrees of freedom"
    outcome = "passed" if test["passed"] else "failed"
    tone: Tone = "good" if test["passed"] else "warning"
    return Fact(title, f"d′C⁻¹d {test['statistic']:.2f}: {outcome}", note, tone)


def _by_coordinate(summary: dict[str, Any]) -> Table:
    scale = length_scale(summary["rmse"][axis] for axis in "xyz")
    columns = (
        Column("", numeric=False),
        *(Column(axis, scale.unit, scale.decimals) for axis in "XYZ"),
    )
    rows = tuple(
        (title, *(scale.of(summary[key][axis]) for axis in "xyz"))
        for title, key in (("RMSE", "rmse"), ("Mean", "mean"), ("Largest", "largest"))
    )
    return Table("Check points by coordinate", columns, rows, source="result.json")


def _splines(splines: list[dict[str, Any]]) -> list[Block]:
    scale = length_scale(spline["rms"] for spline in splines)
    columns = [Column("Spline", numeric=False), Column("Points")]
    titles = ("RMS across", "Mean", "Largest", "Mean predicted σ")
    columns += [Column(title, scale.unit, scale.decimals) for title in titles]
    columns += [Column("Beyond"), Column("d′C⁻¹d", "", 2), Column("f", "", 1), Column("Accepted to", "", 2)]
    rows, marks = [], set()
    for k, s in enumerate(splines):
        test = s.get("together") or {}
        row: list[Cell] = [s["id"], s["n"]]
        row += [scale.of(s.get(key)) for key in ("rms", "mean", "max", "sigma_mean")]
        row += [s.get("beyond"), test.get("statistic"), test.get("degrees"), test.get("critical")]
        rows.append(tuple(row))
        if s.get("beyond") or not test.get("passed", True):
            marks.add(k)
    caption = "Check splines: distance across, adjusted to given"
    note = (
        "Beyond: given points whose distance is larger than predicted, α for all of them. d′C⁻¹d: all points together, "
        "with f effective degrees of freedom, as neighbours on a curve are correlated."
    )
    return [Table(caption, tuple(columns), tuple(rows), frozenset(marks), "result.json"), Note(note)]
