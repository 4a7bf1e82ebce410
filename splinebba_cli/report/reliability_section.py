"""How well errors of observations are found, and what those do that are not."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Fact, Facts, Note, Section, Table
from splinebba_cli.report.kind_names import in_words
from splinebba_cli.report.residual_figure_blocks import reliability_blocks
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import angle_scale, length_scale

_MULTIPLICITY = {
    "none": "α belongs to every single test",
    "sidak": "α belongs to all tests together (Šidák)",
    "bonferroni": "α belongs to all tests together (Bonferroni)",
}
_STATISTIC = {"w": "w (Baarda), σ₀ known", "tau": "τ (Pope), σ₀ estimated"}


def reliability_section(data: ResultData) -> Section:
    """Critical values, redundancy numbers and minimal detectable biases by kind, most influential observations."""
    tests = data.content.get("tests")
    if not tests:
        return Section("reliability", "Tests and reliability of single observations", ())
    expected = tests["tests"] * tests["alpha_single"]
    items = (
        Fact("Statistic", _STATISTIC[tests["statistic"]]),
        Fact(
            "Critical value",
            f"{tests['critical']:.2f}",
            f"α = {tests['alpha']:g}; {_MULTIPLICITY[tests['multiplicity']]}",
        ),
        Fact(
            "Beyond it",
            f"{tests['beyond']} of {tests['tests']}",
            f"expected of good measurements: {expected:.{1 if expected < 100 else 0}f}",
        ),
        Fact("Power 1 − β", f"{tests['power']:g}", f"noncentrality δ₀ = {tests['noncentrality']:.2f}"),
    )
    blocks: list[Block] = [Facts(items), _kinds(tests)]
    blocks += reliability_blocks(data)
    if tests["influences"]:
        bent = any(
            one["orientation"]["sigmas"] > 0.0 for one in tests["influences"]
        )  # none where images are fixed
        blocks += [_influences(tests["influences"], bent), Note(_explanation(bent))]
    return Section("reliability", "Tests and reliability of single observations", tuple(blocks))


def _explanation(bent: bool) -> str:
    to = (
        "to the orientation of the image that it bends most, in standard deviations of that orientation, and in "
        "metres and angles wherever its effect is largest"
        if bent
        else "to the object, where its effect is largest; all orientations are fixed"
    )
    return (
        "An error as large as the minimal detectable bias stays undetected with the probability β. The columns say "
        f"what it then does: {to}. A point on a spline is tested across the spline: along it every measured point has "
        "a location of its own, which takes any error."
    )


def _kinds(tests: dict[str, Any]) -> Table:
    columns = (
        Column("Observations", numeric=False),
        Column("Number"),
        Column("r smallest", "", 3),
        Column("r mean", "", 3),
        Column("r < 0.1", help="weakly controlled"),
        Column("r < 0.001", help="not controlled"),
        Column("MDB median", numeric=False),
        Column("MDB largest", numeric=False),
        Column("Largest |τ|" if tests["statistic"] == "tau" else "Largest |w|", "", 2),
    )
    rows: list[tuple[Cell, ...]] = []
    for kind in tests["kinds"]:
        r, bias = kind["redundancy"], kind["minimal_detectable_bias"]
        sizes = [_size(bias[key], kind["unit"]) for key in ("median", "max")]
        rows.append(
            (
                in_words(kind["kind"]),
                kind["n"],
                r["min"],
                r["mean"],
                kind["weak"],
                kind["uncontrolled"],
                *sizes,
                kind["largest"],
            )
        )
    note = "r: redundancy number, the share of an error that its own residual shows. MDB: minimal detectable bias."
    return Table("Reliability by kind of observation", columns, tuple(rows), note=note)


def _size(value: float | None, unit: str) -> str:
    """A bias with a unit that suits its size."""
    if value is None:
        return "–"
    if unit == "deg":
        return angle_scale([value]).text(value)
    if unit == "mm":
        return f"{1e3 * value:.3g} µm" if value < 1.0 else f"{value:.3g} mm"
    return length_scale([value]).text(value)


def _influences(influences: list[dict[str, Any]], bent: bool) -> Table:
    columns = [
        Column("Observation", numeric=False),
        Column("r", "", 3),
        Column("MDB", numeric=False),
        *(_ORIENTATION if bent else ()),
        Column("Object", numeric=False),
        Column("at", numeric=False),
    ]
    rows: list[tuple[Cell, ...]] = [
        (
            one["observation"].replace("`", ""),
            one["redundancy"],
            _size(one["minimal_detectable_bias"], one["unit"]),
            *(_on_orientation(one) if bent else ()),
            _size(one["object"]["m"], "m"),
            one["object"]["feature"].replace("`", ""),
        )
        for one in influences
    ]
    return Table("Observations whose undetected errors do most", tuple(columns), tuple(rows))


_ORIENTATION = (
    Column("Orientation", "σ", 2, help="largest effect on the orientation of an image"),
    Column("of image", numeric=False),
    Column("Position", numeric=False),
    Column("of image", numeric=False),
    Column("Angle", numeric=False),
    Column("of image", numeric=False),
)


def _on_orientation(one: dict[str, Any]) -> tuple[Cell, ...]:
    position, angle = one["position"], one["angle"]
    return (
        one["orientation"]["sigmas"],
        one["orientation"]["image"],
        _size(position["m"], "m"),
        position["image"],
        _size(angle["deg"], "deg"),
        angle["image"],
    )
