"""What ``chains`` says about the chains that it has read."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.blocks import Column, Table

if TYPE_CHECKING:
    from splinebba_cli.exchange.chain_conversion import ConvertedChains

NEXT = "observations: {{chains: [{{table: {table}, image_coordinates: …, sigma_px: …}}]}}"


def chains_table(converted: ConvertedChains) -> Table:
    """Chains and points of every image, those of the files and those that stay."""
    columns = (
        Column("Image", numeric=False),
        Column("Chains"),
        Column("Points"),
        Column("Chains left out"),
        Column("Points left out"),
    )
    rows = tuple(
        (each.image, each.chains, each.points, each.chains_read - each.chains, each.points_read - each.points)
        for each in converted.counts
    )
    return Table("Chains", columns, rows)


def chains_data(converted: ConvertedChains) -> dict[str, Any]:
    """The same as plain data."""
    return {"images": [asdict(each) for each in converted.counts]}


def next_step(table: str) -> str:
    """What a project has to say of the table; what only the user knows is left open."""
    return f"In the project: {NEXT.format(table=table)}"
