"""Splines that were built from chains, and the parts of them that images do not hold."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Column, Note, Section, Table
from splinebba_cli.report.scale import length_scale

KINDS = {
    "epipolar": "runs along the epipolar direction of its images",
    "bridged": "no image shows it: bridged between its ends",
    "two_images": "in two images only: nothing checks it",
}


def new_splines_section(content: dict[str, Any]) -> Section:
    """Tables of the new splines and of their weak parts; nothing where none was built."""
    built = content["new_splines"]
    if not built:
        return Section("new-splines", "New splines", ())
    scale = length_scale([each["length_m"] for each in built])
    columns = (
        Column("Spline", numeric=False),
        Column("Knots"),
        Column("Images"),
        Column("Chains"),
        Column("Length", scale.unit, scale.decimals),
        Column("In three images", "%", 1, help="share of the length that at least three images see"),
        Column("Weak parts"),
    )
    rows = tuple(
        (
            each["id"],
            each["knots"],
            len(each["images"]),
            len(each["chains"]),
            scale.of(each["length_m"]),
            100.0 * each["length_in_three_images_m"] / each["length_m"] if each["length_m"] else None,
            len(each["weak_parts"]),
        )
        for each in built
    )
    marked = frozenset(k for k, each in enumerate(built) if each["weak_parts"])
    blocks: list[Block] = [Table("Splines built from chains", columns, rows, marked, source="match.json")]
    weak = _weak_parts(built)
    blocks.append(weak if weak.rows else Note("No part of a new spline is weak."))
    return Section("new-splines", "New splines", tuple(blocks))


def _weak_parts(built: list[dict[str, Any]]) -> Table:
    parts = [(each["id"], part) for each in built for part in each["weak_parts"]]
    scale = length_scale([part["sigma_m"] for _, part in parts])
    columns = (
        Column("Spline", numeric=False),
        Column("From", "u", 3),
        Column("To", "u", 3),
        Column("σ across, max", scale.unit, scale.decimals),
        Column("Why", numeric=False),
    )
    rows = tuple(
        (id, part["first"], part["last"], scale.of(part["sigma_m"]), KINDS.get(part["kind"], part["kind"]))
        for id, part in parts
    )
    note = "Measure more in these parts, or in images that see them from elsewhere, before you rely on them."
    return Table("Weak parts", columns, rows, source="match.json", note=note)
