"""Residuals of image points, of control and priors, and what the conditions take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from splinebba_cli.report.blocks import (
    Block,
    Cell,
    Column,
    Fact,
    Facts,
    LazyRows,
    Note,
    Section,
    Table,
)
from splinebba_cli.report.kind_names import in_words
from splinebba_cli.report.residual_figure_blocks import histogram_blocks, image_residual_blocks
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import angle_scale, length_scale

_WORST = 20
_CONDITIONS = ("gauge", "shape", "datum")


def residuals_section(data: ResultData) -> Section:
    """Residuals of image points: histogram, per group, per image, the worst ones."""
    residuals = data["residuals"]
    if not any(group["n"] for group in residuals["groups"]):
        return Section("residuals", "Residuals of image points", ())
    blocks: list[Block] = [_groups_table(residuals)]
    if residuals.get("linked"):
        blocks.append(_linked_table(residuals["linked"]))
    blocks += histogram_blocks(data)
    blocks += image_residual_blocks(data)
    blocks.append(_images_table(residuals))
    if data.residuals.rows and data.content.get("tests"):
        blocks += _worst(data)
    return Section("residuals", "Residuals of image points", tuple(blocks))


def _in_pixels(residuals: dict[str, Any]) -> bool:
    return any(group["rms_px"] is not None for group in residuals["groups"])


def _groups_table(residuals: dict[str, Any]) -> Table:
    names = {"points": "points, per coordinate", "splines": "splines, across the curve"}
    pixels = _in_pixels(residuals)
    columns = [
        Column("Group", numeric=False),
        Column("Kind", numeric=False),
        Column("Image points"),
        Column("RMS", "µm", 2),
        Column("Largest", "µm", 2),
    ]
    columns += [Column("RMS", "px", 3), Column("Largest", "px", 3)] if pixels else []
    columns.append(Column("Redundancy", "", 2))
    rows = []
    for group in residuals["groups"]:
        row: list[Cell] = [
            group["group"],
            names[group["kind"]],
            group["n"],
            *_lengths(group, pixels),
            group["redundancy"],
        ]
        rows.append(tuple(row))
    note = f"Residuals are {residuals['sign'].replace('-', '−')}."
    return Table("Residuals by group", tuple(columns), tuple(rows), note=note)


def _linked_table(linked: list[dict[str, Any]]) -> Table:
    """Arc lengths, tangents and distances, one row a group."""
    columns = (
        Column("Group", numeric=False),
        Column("Kind", numeric=False),
        Column("Observations"),
        Column("RMS", numeric=False),
        Column("Largest", numeric=False),
        Column("Redundancy", "", 2),
    )
    rows: list[tuple[Cell, ...]] = []
    for group in linked:
        if group["unit"] == "deg":
            texts = [f"{group[key]:.3f}°" for key in ("rms", "max")]
        elif group["unit"] == "m":
            scale = length_scale([group["rms"]])
            texts = [scale.text(group[key]) for key in ("rms", "max")]
        else:
            texts = [f"{1e3 * group[key]:.2f} µm" for key in ("rms", "max")]
        rows.append((group["group"], group["kind"], group["n"], *texts, group["redundancy"]))
    note = (
        "Arc lengths and tangents come from the same edge pixels as the points and are correlated with them."
    )
    return Table("Arc lengths, tangents and distances", columns, tuple(rows), note=note)


def _lengths(summary: dict[str, Any], pixels: bool) -> list[Cell]:
    cells: list[Cell] = [None if summary[key] is None else 1e3 * summary[key] for key in ("rms_mm", "max_mm")]
    return cells + ([summary["rms_px"], summary["max_px"]] if pixels else [])


def _images_table(residuals: dict[str, Any]) -> Table:
    pixels = _in_pixels(residuals)
    columns = [Column("Image", numeric=False)]
    for group in ("points", "splines"):
        columns += [
            Column(f"On {group}"),
            Column(f"RMS {group}", "µm", 2),
            Column(f"Largest {group}", "µm", 2),
        ]
        columns += [Column(f"RMS {group}", "px", 3), Column(f"Largest {group}", "px", 3)] if pixels else []
    rows = []
    for image in residuals["images"]:
        row: list[Cell] = [image["id"]]
        for group in ("points", "splines"):
            row += [image[group]["n"], *_lengths(image[group], pixels)]
        rows.append(tuple(row))
    return Table(
        "Residuals by image", tuple(columns), tuple(rows), source="result.json", folded=len(rows) > 60
    )


def _worst(data: ResultData) -> list[Block]:
    table = data.residuals
    w = np.stack([table.numbers(f"standardized_{name}") for name in ("x", "y", "across")], axis=1)
    size = np.nan_to_num(np.abs(w), nan=0.0)
    tests = data["tests"]
    size *= _tested_factor(data)
    row_size = size.max(axis=1)
    letter, critical = ("τ" if tests["statistic"] == "tau" else "w"), tests["critical"]
    beyond, tested = int((size > critical).sum()), int(np.isfinite(w).sum())
    order = np.argsort(-row_size, kind="stable")[:_WORST]
    v = np.stack([table.numbers(f"residual_{name}_mm") for name in ("x", "y", "across")], axis=1)
    place = np.stack([table.numbers(f"measured_{name}_mm") for name in ("x", "y")], axis=1)
    number = _numbers_within(table["kind"])
    names = ("x", "y", "across")
    rows: list[tuple[Cell, ...]] = []
    for i in order.tolist():
        j = int(size[i].argmax())
        rows.append(
            (
                table["image"][i],
                table["kind"][i],
                table["feature"][i],
                number[i],
                *place[i].tolist(),
                names[j],
                1e3 * float(v[i, j]),
                float(np.copysign(size[i, j], w[i, j])),
            )
        )
    columns = (
        Column("Image", numeric=False),
        Column("Kind", numeric=False),
        Column("Feature", numeric=False),
        Column("Row", help="number of the observation among those of its kind, in the order of the project"),
        Column("x", "mm", 3, help="measured photo coordinate, to the right"),
        Column("y", "mm", 3, help="measured photo coordinate, up"),
        Column("Direction", numeric=False),
        Column("v", "µm", 2, help="adjusted − measured"),
        Column(letter, "", 2),
    )
    marked = frozenset(k for k, i in enumerate(order.tolist()) if row_size[i] > critical)
    expected = f"expected of good measurements: {tests['alpha_single'] * tested:.1f}"
    note = f"{beyond} of {tested} tested image coordinates have |{letter}| > {critical:.2f} ({expected})."
    return [
        Table("Largest standardized residuals", columns, tuple(rows), marked, "residuals.csv"),
        Note(note),
    ]


def _tested_factor(data: ResultData) -> float:
    """What is held against the critical value over w: 1, or σ₀ / σ̂₀ where τ is tested."""
    if (data.content.get("tests") or {}).get("statistic") != "tau":
        return 1.0
    return float(data["statistics"]["sigma0_prior"] / data["statistics"]["sigma0"])


def _numbers_within(kinds: Sequence[str]) -> list[int]:
    """Numbers of the rows among those of their kind, from 1."""
    count: dict[str, int] = {}
    found = []
    for kind in kinds:
        count[kind] = count.get(kind, 0) + 1
        found.append(count[kind])
    return found


def priors_section(data: ResultData) -> Section:
    """Residuals of control and prior equations."""
    table = data.priors
    groups = [group for group in data["residuals"]["priors"] if group["kind"] not in _CONDITIONS]
    if not groups:
        return Section("priors", "Control and priors", ())
    blocks: list[Block] = []
    columns = (
        Column("Kind", numeric=False),
        Column("Equations"),
        Column("RMS", numeric=False),
        Column("Largest", numeric=False),
        Column("Redundancy", "", 2),
    )
    rows: list[tuple[Cell, ...]] = []
    for group in groups:
        scale = (angle_scale if group["unit"] == "deg" else length_scale)([group["rms"]])
        rows.append(
            (
                in_words(group["kind"]),
                group["n"],
                scale.text(group["rms"]),
                scale.text(group["max"]),
                group["redundancy"],
            )
        )
    blocks.append(Table("Residuals by kind", columns, tuple(rows)))
    if table.rows:
        for unit in ("m", "deg"):
            block = _prior_rows(data, unit)
            blocks += [block] if block is not None else []
    return Section("priors", "Control and priors", tuple(blocks))


def _prior_rows(data: ResultData, unit: str) -> Table | None:
    table = data.priors
    residual, sigma, redundancy, w = (
        table.numbers(name) for name in ("residual", "sigma", "redundancy", "standardized")
    )
    kind, subject, component = table["kind"], table["subject"], table["component"]
    chosen = [
        i
        for i, (its_kind, its_unit) in enumerate(zip(kind, table["unit"], strict=True))
        if its_unit == unit and its_kind not in _CONDITIONS
    ]
    if not chosen:
        return None
    scale = (angle_scale if unit == "deg" else length_scale)(sigma[chosen].tolist())
    columns = (
        Column("Kind", numeric=False),
        Column("Subject", numeric=False),
        Column("Component", numeric=False),
        Column("Adjusted − given", scale.unit, scale.decimals),
        Column("σ given", scale.unit, scale.decimals),
        Column("v / σ", "", 2),
        Column("r", "", 3, help="redundancy number"),
        Column("w", "", 2, help="v / (σ √r), what the test of the single value looks at"),
    )
    ratio = np.divide(residual, sigma, out=np.full(len(sigma), np.nan), where=sigma > 0.0)

    def row(number: int) -> tuple[Cell, ...]:
        i = chosen[number]
        size = float(ratio[i]) if sigma[i] > 0.0 else None
        values = (scale.of(float(residual[i])), scale.of(float(sigma[i])), size, float(redundancy[i]))
        tested = float(w[i]) if np.isfinite(w[i]) else None
        return (in_words(kind[i]), subject[i], component[i], *values, tested)

    rows = LazyRows(len(chosen), row)
    critical = (data.content.get("tests") or {}).get("critical", np.inf)
    marked = frozenset(np.flatnonzero(_tested_factor(data) * np.abs(w[chosen]) > critical).tolist())
    caption = "Residuals of angles" if unit == "deg" else "Residuals of coordinates"
    return Table(caption, columns, rows, marked, "prior_residuals.csv", folded=len(rows) > 60)


def conditions_section(data: ResultData) -> Section:
    """How many gauge and datum conditions there are, and what they take."""
    s = data["statistics"]
    if not s["conditions"]:
        return Section("conditions", "Gauge and datum", (Note("No gauge or datum condition was needed."),))
    cost_share = _share(s["condition_cost"], s["vtpv"])
    redundancy_share = _share(s["condition_redundancy"], s["redundancy"])
    items = [
        Fact("Conditions", f"{s['conditions']}", f"datum: {data['settings']['datum']}"),
        Fact("Rank defect of measurements and priors", f"{s['rank_defect']}"),
        Fact("Share of v′Pv", cost_share, "0 where the conditions are pure gauge"),
        Fact(
            "Share of the redundancy",
            redundancy_share,
            "part that the conditions bring, not the measurements",
        ),
    ]
    blocks: list[Block] = [Facts(tuple(items))]
    rows: list[tuple[Cell, ...]] = []
    for group in data["residuals"]["priors"]:
        if group["kind"] in _CONDITIONS:
            scale = (angle_scale if group["unit"] == "deg" else length_scale)([group["rms"]])
            rows.append(
                (
                    group["kind"],
                    group["n"],
                    scale.text(group["rms"]),
                    scale.text(group["max"]),
                    group["redundancy"],
                )
            )
    if rows:
        columns = (
            Column("Kind", numeric=False),
            Column("Equations"),
            Column("RMS", numeric=False),
            Column("Largest", numeric=False),
            Column("Redundancy", "", 3),
        )
        blocks.append(
            Table("Residuals of the conditions", columns, tuple(rows), source="prior_residuals.csv")
        )
    text = (
        "Knots of a free spline may slide along the curve without changing it. Weak conditions along it "
        "keep them in place; the shape of the curve and its precision across do not depend on them. Shape "
        "conditions make a circle of a conic: they count as conditions and fill no rank defect."
    )
    blocks.append(Note(text))
    return Section("conditions", "Gauge and datum", tuple(blocks))


def _share(part: float | None, whole: float | None) -> str:
    return f"{100 * part / whole:.2f} %" if part is not None and whole else "–"
