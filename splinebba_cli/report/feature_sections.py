"""Splines, points and checks."""

from __future__ import annotations

from bisect import bisect_right
from itertools import accumulate
from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, LazyRows, Note, Section, Table
from splinebba_cli.report.figure_blocks import spline_blocks
from splinebba_cli.report.orientation_section import subjects_with_problems
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale, position_decimals
from splinebba_cli.report.shape_tables import shape_tables


def splines_section(data: ResultData) -> Section:
    """Precision across the splines, knots, Lee's coefficients, a figure each."""
    splines = data["splines"]
    if not splines:
        return Section("splines", "Splines", ())
    blocks: list[Block] = [
        splines_table(data),
        Note(
            "The measurements determine a spline across its direction; σ across is the larger semi-axis of "
            "the standard ellipse in the normal plane. σ along depends on the gauge conditions "
            "(datum-dependent) and says nothing about the precision of the curve."
        ),
    ]
    blocks += spline_blocks(data)
    blocks += shape_tables(splines)
    blocks.append(_knots_table(splines))
    if "segments_table" in data.content:
        blocks.append(Note(f"The coefficients of the segments stand in {data['segments_table']}.csv."))
    else:
        blocks.append(_coefficients_table(splines))
    return Section("splines", "Splines", tuple(blocks))


def splines_table(data: ResultData) -> Table:
    """One row a spline: what it is, how well it is measured, how precise it is."""
    splines = data["splines"]
    summary = {item["id"]: item for item in data["residuals"]["splines"]}
    across = length_scale(spline["sigma_across"]["mean"] for spline in splines)
    along = length_scale(sigma for spline in splines for sigma in spline["sigma_along_datum_dependent"])
    in_pixels = any(item["rms_px"] is not None for item in summary.values())
    columns = [
        Column("Spline", numeric=False),
        Column("Role", numeric=False),
        Column("Family", numeric=False),
        Column("Knots"),
        Column("Images"),
        Column("Image points"),
        Column("RMS across", "µm", 2, help="residuals across the curve, in the photo"),
    ]
    columns += [Column("RMS across", "px", 3)] if in_pixels else []
    columns += [
        Column("σ across, mean", across.unit, across.decimals),
        Column("σ across, max", across.unit, across.decimals),
        Column("σ along, median", along.unit, along.decimals, help="datum-dependent"),
    ]
    rows = []
    for spline in splines:
        rms = summary[spline["id"]]
        row: list[Cell] = [spline["id"], spline["role"], _family(spline), len(spline["knots"])]
        row += [spline["images"], spline["observations"]]
        row.append(None if spline["rms_across_mm"] is None else 1e3 * spline["rms_across_mm"])
        row += [rms["rms_px"]] if in_pixels else []
        row += [across.of(spline["sigma_across"]["mean"]), across.of(spline["sigma_across"]["max"])]
        row.append(along.of(_median(spline["sigma_along_datum_dependent"])))
        rows.append(tuple(row))
    marked = subjects_with_problems(data, "spline")
    return Table(
        "Splines: measurements and precision",
        tuple(columns),
        tuple(rows),
        frozenset(i for i, spline in enumerate(splines) if spline["id"] in marked),
        "result.json",
    )


def _family(spline: dict[str, Any]) -> str:
    name = str(spline["family"]).replace("_", " ")
    return f"{name}, closed" if spline["closed"] else name


def _median(values: list[float | None]) -> float | None:
    found = sorted(value for value in values if value is not None)
    return found[len(found) // 2] if found else None


def _knots_table(splines: list[dict[str, Any]]) -> Table:
    sigmas = [value for spline in splines for row in spline["knot_sigma"] for value in row]
    scale, decimals = length_scale(sigmas), position_decimals(sigmas)
    columns = [Column("Spline", numeric=False), Column("Knot"), Column("u", "", 4)]
    columns += [Column(axis, "m", decimals) for axis in "XYZ"]
    columns += [Column(f"σ {axis}", scale.unit, scale.decimals) for axis in "XYZ"]
    counts = (
        min(len(spline[key]) for key in ("knot_parameters", "knots", "knot_sigma")) for spline in splines
    )
    begins = list(accumulate(counts, initial=0))

    def row(place: int) -> tuple[Cell, ...]:
        number = bisect_right(begins, place) - 1
        spline, knot = splines[number], place - begins[number]
        sigma = [scale.of(value) for value in spline["knot_sigma"][knot]]
        return (spline["id"], knot, spline["knot_parameters"][knot], *spline["knots"][knot], *sigma)

    rows = LazyRows(begins[-1], row)
    note = "σ of a knot holds its part along the curve, which is datum-dependent."
    return Table("Knots", tuple(columns), rows, source="result.json", folded=True, note=note)


def _coefficients_table(splines: list[dict[str, Any]]) -> Table:
    sigmas = [
        value
        for spline in splines
        for segment in spline["segments"]
        for letter in "abc"
        for value in segment[f"sigma_{letter}"]
    ]
    scale, decimals = length_scale(sigmas), position_decimals(sigmas)
    columns = [
        Column("Spline", numeric=False),
        Column("Segment"),
        Column("u from", "", 4),
        Column("u to", "", 4),
    ]
    columns += [Column("Coordinate", numeric=False)]
    columns += [Column(f"t{power}", "m", decimals) for power in "⁰¹²³"]
    columns += [Column(f"σ t{power}", scale.unit, scale.decimals) for power in "⁰¹²³"]
    rows: list[tuple[Cell, ...]] = []
    for spline in splines:
        for number, segment in enumerate(spline["segments"]):
            for axis, letter in zip("XYZ", "abc", strict=True):
                head: tuple[Cell, ...] = (spline["id"], number, *segment["interval"], f"{axis} ({letter})")
                sigma = [scale.of(value) for value in segment[f"sigma_{letter}"]]
                rows.append((*head, *segment[letter], *sigma))
    note = "X = a₀ + a₁t + a₂t² + a₃t³, Y with b, Z with c; t runs from 0 to 1 over the interval of u."
    return Table(
        "Coefficients of the segments",
        tuple(columns),
        tuple(rows),
        source="spline_coefficients.csv",
        folded=True,
        note=note,
    )


def points_section(data: ResultData) -> Section:
    """Adjusted object points."""
    points = data["points"]
    if not points:
        return Section("points", "Points", ())
    sigmas = [point["sigma"][axis] for point in points for axis in "xyz"]
    scale, decimals = length_scale(sigmas), position_decimals(sigmas)
    columns = [Column("Point", numeric=False), Column("Role", numeric=False)]
    columns += [Column(axis, "m", decimals) for axis in "XYZ"]
    columns += [Column(f"σ {axis}", scale.unit, scale.decimals) for axis in "XYZ"]
    columns.append(Column("Rays"))
    rows = tuple(
        (
            point["id"],
            point["role"],
            *(point[axis] for axis in "xyz"),
            *(scale.of(point["sigma"][axis]) for axis in "xyz"),
            point["rays"],
        )
        for point in points
    )
    marked = subjects_with_problems(data, "point")
    marks = frozenset(i for i, point in enumerate(points) if point["id"] in marked)
    table = Table(
        "Adjusted points and standard deviations",
        tuple(columns),
        rows,
        marks,
        "points.csv",
        folded=len(points) > 60,
    )
    return Section("points", "Points", (table,))
