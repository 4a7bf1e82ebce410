"""What the residuals say about the model: variances of groups, errors that groups share, systematic effects."""

from __future__ import annotations

from typing import Any

from splinebba_cli.core.quality.systematic_findings import LEAST_CRITICAL
from splinebba_cli.report.blocks import Block, Cell, Column, Note, Section, Table
from splinebba_cli.report.kind_names import KINDS
from splinebba_cli.report.residual_figure_blocks import residual_grid_blocks, variance_blocks
from splinebba_cli.report.result_data import ResultData

_SHOWN = 30  # groups, the most suspicious first


def variance_section(data: ResultData) -> Section:
    """σ̂ of every group of observations."""
    components = data.content.get("variance_components", [])
    if not components:
        return Section("variance-components", "Variance components", ())
    weighted = any(each["estimated"] for each in components)
    columns = (
        Column("Group", numeric=False),
        Column("Kind", numeric=False),
        Column("Equations"),
        Column("Redundancy", "", 1),
        Column("Factor of σ", "", 3),
        Column("σ̂ / σ", "", 3),
        Column("± ", "", 3),
        Column("Test", numeric=False),
    )
    rows: list[tuple[Cell, ...]] = [
        (
            each["group"],
            KINDS.get(each["kind"], each["kind"]),
            each["observations"],
            each["redundancy"],
            each["factor"],
            each["sigma0"],
            each["sigma0_sigma"],
            _verdict(each),
        )
        for each in components
    ]
    marked = frozenset(k for k, each in enumerate(components) if not each["passed"])
    note = (
        "σ̂ / σ: what the residuals of the group say of the σ used; 1 is right. Each group is held against its own χ² "
        "interval, α for all groups together."
    )
    if weighted:
        note += (
            " The σ used is the given one times the factor; it was estimated, so that σ̂ / σ is 1 at the end. The "
            "global test then says nothing about the size of the residuals."
        )
    return Section(
        "variance-components",
        "Variance components",
        (*variance_blocks(components), Table("Groups", columns, tuple(rows), marked, note=note)),
    )


def _verdict(component: dict[str, Any]) -> str:
    if component["sigma0"] is None:
        return "no redundancy"
    if component["estimated"]:
        return "σ estimated"
    if component["passed"]:
        return "passed"
    return "σ too small" if component["sigma0"] > 1.0 else "σ too large"


def groups_section(data: ResultData) -> Section:
    """Errors that all observations of a chain or of a control feature would share."""
    found = data.content.get("group_tests", {"tests": []})
    tests = sorted(
        found["tests"], key=lambda test: -test["statistic"] / max(test["critical"], LEAST_CRITICAL)
    )
    if not tests:
        return Section("groups", "Common errors", ())
    columns = (
        Column("Group", numeric=False),
        Column("Equations"),
        Column("Common error", numeric=False),
        Column("σ", numeric=False),
        Column("Detectable", numeric=False),
        Column("T", "", 2),
        Column("Critical", "", 2),
    )
    rows: list[tuple[Cell, ...]] = []
    for test in tests[:_SHOWN]:
        factor, unit = (1e3, "µm") if test["unit"] == "mm" else (1.0, "m")
        rows.append(
            (
                _plain(test["name"]),
                test["observations"],
                _vector(test["estimate"], factor, unit),
                _vector(test["sigma"], factor, unit),
                _vector([test["minimal_detectable"]], factor, unit),
                test["statistic"],
                test["critical"],
            )
        )
    marked = frozenset(k for k, test in enumerate(tests[:_SHOWN]) if not test["passed"])
    failed = sum(not test["passed"] for test in tests)
    note = (
        f"{failed} of {found['tested']} tested groups have a common error ({found['possible']} groups; a group whose "
        "error the unknowns take up cannot be tested). Chains: shift across the spline, positive to the left of its "
        "direction in the image; control: given − true (X, Y, Z), – where the residuals do not show a component. A "
        "wrong group spoils its neighbours: begin with the first."
    )
    table = Table(
        "Common errors, the most suspicious first", columns, tuple(rows), marked, "group_tests.csv", note=note
    )
    return Section("groups", "Common errors", (table,))


def _vector(values: list[float | None], factor: float, unit: str) -> str:
    texts = ["–" if value is None else f"{factor * value:.2g}" for value in values]
    return f"{', '.join(texts)} {unit}"


def _plain(name: str) -> str:
    return name.replace("`", "")


def systematic_section(data: ResultData) -> Section:
    """Effects that single residuals do not show, and mean residuals over the image format."""
    found = data.content.get("systematic", {"effects": [], "grids": []})
    effects = sorted(found["effects"], key=lambda effect: (not effect["significant"], _order(effect)))
    if not effects and not found["grids"]:
        return Section("systematic", "Systematic effects", ())
    blocks: list[Block] = []
    columns = (
        Column("Effect", numeric=False),
        Column("Subject", numeric=False),
        Column("Estimate", numeric=False),
        Column("Statistic", "", 2),
        Column("Critical", "", 2),
        Column("Shown", "%", 1),
        Column("What it is", numeric=False),
    )
    rows: list[tuple[Cell, ...]] = [
        (
            effect["kind"],
            _plain(effect["subject"]),
            "–" if effect["estimate"] is None else f"{effect['estimate']:.2g} {effect['unit']}".strip(),
            effect["statistic"],
            effect["critical"],
            100.0 * effect["shown"],
            effect["detail"],
        )
        for effect in effects
    ]
    marked = frozenset(k for k, effect in enumerate(effects) if effect["significant"])
    note = (
        "Shown: the share of such an effect that is left in the residuals; the unknowns take up the rest, which every "
        "test allows for. α belongs to all tests of a kind together."
    )
    table = Table(
        "Tests for systematic effects",
        columns,
        tuple(rows),
        marked,
        "systematic_effects.csv",
        len(rows) > 60,
        note,
    )
    blocks.append(table)
    blocks += residual_grid_blocks(found["grids"])
    if not effects:
        blocks.append(Note("No effect could be tested."))
    return Section("systematic", "Systematic effects", tuple(blocks))


def _order(effect: dict[str, Any]) -> tuple[int, float]:
    kinds = ("radial trend", "tangential trend", "grid", "image mean", "drift", "strip", "run along curve")
    return kinds.index(effect["kind"]), -effect["statistic"] / max(effect["critical"], LEAST_CRITICAL)
