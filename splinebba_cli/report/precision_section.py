"""Ellipses and uncertainties of positions with a confidence; correlations beyond the threshold."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Fact, Facts, Note, Section, Table
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale

_KINDS = (("images", "Image", "Perspective centres"), ("points", "Point", "Points"))


def precision_section(data: ResultData) -> Section:
    """Confidence factors, error ellipses, the worst first; correlations between features."""
    precision = data.content.get("precision")
    if not precision:
        return Section("precision", "Precision of positions", ())
    blocks: list[Block] = [Facts(_factors(precision))]
    blocks += [
        _ellipses(precision, key, title, caption) for key, title, caption in _KINDS if precision[key]["worst"]
    ]
    blocks.append(
        Note(
            _explanation(
                precision,
                free=data["statistics"]["rank_defect"] > 0 and data["settings"]["datum"] != "control",
            )
        )
    )
    blocks.append(_correlations(precision))
    return Section("precision", "Precision of positions", tuple(blocks))


def _factors(precision: dict[str, Any]) -> tuple[Fact, ...]:
    degrees = precision["degrees"]
    known = (
        "σ₀ is known: normal, χ²" if degrees is None else f"σ̂₀ estimated, redundancy {degrees:.0f}: t and F"
    )
    facts = [
        Fact("Confidence", f"{100 * precision['confidence']:g} %", known),
        Fact("Factor of σ", f"{precision['interval_factor']:.4f}", "interval of one coordinate"),
        Fact(
            "Factor of ellipses",
            f"{precision['ellipse_factor']:.4f}",
            "horizontal ones, and those across splines",
        ),
        Fact("Factor of ellipsoids", f"{precision['ellipsoid_factor']:.4f}"),
    ]
    for key, _, caption in _KINDS:
        part = precision[key]
        if part["count"] and part["horizontal_rms_m"] is not None:
            scale = length_scale([part["horizontal_rms_m"], part["vertical_rms_m"]])
            text = f"{scale.text(part['horizontal_rms_m'])} horizontal, {scale.text(part['vertical_rms_m'])} vertical"
            facts.append(Fact(f"{caption}, uncertainty", text, f"root mean square of {part['count']}"))
    return tuple(facts)


def _ellipses(precision: dict[str, Any], key: str, title: str, caption: str) -> Table:
    worst = precision[key]["worst"]
    scale = length_scale(value for item in worst for value in item["semi_axes_m"])
    columns = [Column(title, numeric=False)]
    columns += [Column(name, scale.unit, scale.decimals) for name in ("Semi-major", "Semi-minor")]
    columns.append(Column("Azimuth", "°", 1))
    columns += [Column(f"Ellipsoid {k}", scale.unit, scale.decimals) for k in (1, 2, 3)]
    columns += [Column(name, scale.unit, scale.decimals) for name in ("Radius", "Vertical ±")]
    rows: list[tuple[Cell, ...]] = [
        (
            item["id"],
            *(scale.of(value) for value in item["semi_axes_m"]),
            item["azimuth_deg"],
            *(scale.of(value) for value in item["ellipsoid_m"]),
            scale.of(item["horizontal_m"]),
            scale.of(item["vertical_m"]),
        )
        for item in worst
    ]
    count = precision[key]["count"]
    note = f"The {len(worst)} with the largest radius of {count}." if count > len(worst) else ""
    text = f"{caption}: standard ellipses, and uncertainty with {100 * precision['confidence']:g} %"
    return Table(text, tuple(columns), tuple(rows), source="error_ellipses.csv", note=note)


def _explanation(precision: dict[str, Any], free: bool) -> str:
    text = (
        "Azimuths run from the Y axis clockwise; ellipsoid 1 to 3: its semi-axes. Multiply standard ellipses by "
        f"{precision['ellipse_factor']:.3f} and ellipsoids by {precision['ellipsoid_factor']:.3f} for "
        f"{100 * precision['confidence']:g} %. Radius: the circle that holds the horizontal position with this "
        "confidence; vertical: the interval of the height."
    )
    return f"{text} The datum is free: all of these figures depend on its choice." if free else text


def _correlations(precision: dict[str, Any]) -> Block:
    """Correlations of points and between features; those inside an image stand with the orientations."""
    threshold = precision["correlation_threshold"]
    pairs = [p for p in precision["correlations"] if not _inside_image(p["first"], p["second"])]
    if not pairs:
        return Note(
            f"No coordinates of a point and no unknowns of different images are listed beyond {threshold:g}."
        )
    columns = (Column("Unknown", numeric=False), Column("with", numeric=False), Column("r", decimals=4))
    rows = tuple((pair["first"], pair["second"], pair["r"]) for pair in pairs)
    note = f"{precision['correlations_found']} in all, those inside images included."
    caption = f"Correlations beyond {threshold:g} inside points and between features"
    return Table(caption, columns, rows, source="result.json", folded=len(rows) > 20, note=note)


def _inside_image(first: str, second: str) -> bool:
    return first.startswith("image `") and first.rsplit(" ", 1)[0] == second.rsplit(" ", 1)[0]
