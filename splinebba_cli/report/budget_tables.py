"""The redundancy budget on the console: splines with the count of the dissertation, points by kind, images."""

from __future__ import annotations

import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING

from splinebba_cli.report.blocks import Column, Table
from splinebba_cli.report.console import rich_table

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

    from splinebba_cli.core.budget import Budget, FeatureBudget

WIDTH = 110
REASONS = 8
NAMES = 4
LEGEND = (
    "rank: with the orientations known; EOP: independent conditions that are left for the orientations; gauge: "
    "conditions on offer; [Lee]: unknowns and redundancy as counted in Lee (2008), tables 5.1 and 5.2"
)
LONGEST = 15  # characters of an id
SOURCE = "--format json has all"


class BudgetTables:
    """A rich renderable of the features and images of a budget."""

    def __init__(self, found: Budget) -> None:
        self._found = found

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Splines and why their count differs, points, images."""
        from rich.text import Text

        splines = [f for f in self._found.features if f.kind == "spline"]
        points = [f for f in self._found.features if f.kind == "point"]
        width = min(WIDTH, options.max_width)
        if splines:
            yield from rich_table(spline_table(splines), width)
            legend = textwrap.wrap(LEGEND, width, initial_indent="  ", subsequent_indent="  ")
            yield from (Text(line, style="dim") for line in legend)
            yield from (Text(line, style="dim") for line in reason_lines(splines, width))
        if points:
            yield from rich_table(point_table(points), width)
        yield from rich_table(image_table(self._found), width)


def spline_table(splines: list[FeatureBudget]) -> Table:
    """One row a spline."""
    columns = (
        Column("Spline", numeric=False), Column("images"), Column("points"), Column("equations"),
        Column("unknowns"), Column("rank"), Column("redundancy"), Column("EOP"), Column("gauge"),
        Column("unknowns", "Lee"), Column("r", "Lee"),
    )  # fmt: skip
    rows = tuple(
        (
            _short(f.id), f.images, f.observations, f.equations, f.unknowns, f.rank, f.redundancy,
            f.orientation_conditions, f.gauge_conditions, f.lee_unknowns, f.lee_redundancy,
        )
        for f in splines
    )  # fmt: skip
    return Table("Splines with the orientations known", columns, rows, source=SOURCE)


def point_table(points: list[FeatureBudget]) -> Table:
    """One row for all points of a role that are seen by so many images; sums of their counts."""
    columns = (
        Column("Points", numeric=False), Column("images"), Column("number"), Column("equations"),
        Column("unknowns"), Column("rank"), Column("redundancy"), Column("EOP"),
    )  # fmt: skip
    number: Counter[tuple[str, int]] = Counter()
    sums: dict[tuple[str, int], list[int | None]] = {}
    for f in points:
        kind = (f.role, f.images)
        own = (f.equations, f.unknowns, f.rank, f.redundancy, f.orientation_conditions)
        before = sums.get(kind, [0] * len(own))
        sums[kind] = [None if a is None or b is None else a + b for a, b in zip(before, own, strict=True)]
        number[kind] += 1
    rows = tuple((*kind, number[kind], *sums[kind]) for kind in sorted(sums))
    return Table("Points with the orientations known, sums", columns, rows, source=SOURCE)


def image_table(found: Budget) -> Table:
    """One row an image."""
    columns = (
        Column("Image", numeric=False), Column("points"), Column("spline points"), Column("arcs"),
        Column("tangents"), Column("priors"), Column("equations"), Column("unknowns"), Column("rank"),
        Column("redundancy"),
    )  # fmt: skip
    rows = tuple(
        (
            _short(i.id), i.points, i.spline_points, i.arc_lengths, i.tangents, i.priors, i.equations, i.unknowns,
            i.rank, i.redundancy,
        )
        for i in found.images
    )  # fmt: skip
    return Table("Images with the features known", columns, rows, source=SOURCE)


def _short(id: str) -> str:
    return id if len(id) <= LONGEST else id[: LONGEST - 1] + "…"


def reason_lines(splines: list[FeatureBudget], width: int) -> list[str]:
    """Why Lee's count is not the rank: each reason once, with the splines that it holds for."""
    names: defaultdict[str, list[str]] = defaultdict(list)
    for f in splines:
        for reason in filter(None, f.reason.split("; ")):
            names[reason].append(f.id)
    lines = []
    for reason, ids in list(names.items())[:REASONS]:
        more = f" and {len(ids) - NAMES} more" if len(ids) > NAMES else ""
        text = f"{', '.join(ids[:NAMES])}{more}: {reason}"
        lines += textwrap.wrap(text, width, initial_indent="  ", subsequent_indent="    ")
    if len(names) > REASONS:
        lines.append(f"  … and {len(names) - REASONS} more reasons ({SOURCE})")
    return [*lines, ""]
