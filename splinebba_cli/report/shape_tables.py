"""Elements of conics, and closed splines of all families in comparable terms."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Table
from splinebba_cli.report.scale import length_scale, position_decimals

Spline = dict[str, Any]


def shape_tables(splines: list[Spline]) -> list[Block]:
    """The tables that there is something to say in."""
    conics = [spline for spline in splines if "conic" in spline]
    closed = [spline for spline in splines if "ellipse" in spline]
    tables: list[Block] = [_conics(conics)] if conics else []
    return tables + ([_comparable(closed)] if closed else [])


def _conics(splines: list[Spline]) -> Table:
    """Centre, semi-axes, eccentricity and normal with their standard deviations."""
    sigmas = [
        s for spline in splines for key in ("centre", "semi_axes") for s in spline["conic"]["sigma"][key]
    ]
    scale, decimals = length_scale(sigmas), position_decimals(sigmas)
    columns = [Column("Spline", numeric=False), Column("Form", numeric=False)]
    names = (*(f"Centre {axis}" for axis in "XYZ"), "Semi-axis a", "Semi-axis b")
    columns += [Column(name, "m", decimals) for name in names]
    columns += [Column(f"σ {name}", scale.unit, scale.decimals) for name in ("X", "Y", "Z", "a", "b")]
    columns += [Column("Eccentricity", "", 6), Column("σ eccentricity", "", 6)]
    columns += [Column(f"Normal {axis}", "", 6) for axis in "XYZ"] + [Column("σ normal", "°", 5)]
    rows: list[tuple[Cell, ...]] = []
    for spline in splines:
        conic, sigma = spline["conic"], spline["conic"]["sigma"]
        lengths = [*conic["centre"], *conic["semi_axes"]]
        spread = [scale.of(value) for value in (*sigma["centre"], *sigma["semi_axes"])]
        shape = [conic["eccentricity"], sigma["eccentricity"], *conic["normal"], sigma["normal_deg"]]
        rows.append((spline["id"], conic["form"], *lengths, *spread, *shape))
    note = "Circle: eccentricity 0; ellipse: below 1; a bounded conic is one of these. The normal points upwards."
    return Table("Elements of conics", tuple(columns), tuple(rows), source="result.json", note=note)


def _comparable(splines: list[Spline]) -> Table:
    """Closed splines of every family by the ellipse that is nearest to them."""
    sigmas = [spline["sigma_across"]["mean"] for spline in splines]
    lengths = [*sigmas, *(spline["ellipse"]["rms"] for spline in splines)]
    scale, decimals = length_scale(lengths), position_decimals(sigmas)
    columns = [Column("Spline", numeric=False), Column("Family", numeric=False)]
    columns += [Column(f"Centre {axis}", "m", decimals) for axis in "XYZ"]
    columns += [Column(f"Semi-axis {name}", "m", decimals) for name in "ab"]
    columns += [Column(f"Normal {axis}", "", 6) for axis in "XYZ"]
    columns += [
        Column("RMS of it", scale.unit, scale.decimals, help="distance of the spline from its ellipse")
    ]
    columns += [Column("σ across, mean", scale.unit, scale.decimals)]
    rows: list[tuple[Cell, ...]] = []
    for spline in splines:
        ellipse = spline["ellipse"]
        row = (spline["id"], str(spline["family"]).replace("_", " "))
        place = (*ellipse["centre"], *ellipse["semi_axes"], *ellipse["normal"])
        rows.append((*row, *place, scale.of(ellipse["rms"]), scale.of(spline["sigma_across"]["mean"])))
    note = (
        "The ellipse nearest to each closed spline, whatever its family; the RMS says how far it is from one."
    )
    return Table(
        "Closed splines in comparable terms",
        tuple(columns),
        tuple(rows),
        source="result.json",
        folded=len(rows) > 20,
        note=note,
    )
