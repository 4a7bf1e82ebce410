"""Unlabelled image points, single or in chains, for the core: millimetres, numbers of chains, directions of edges."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, UnlabelledPoints
from splinebba_cli.project.build_cameras import PhotoFrame
from splinebba_cli.project.build_context import Building, stacked
from splinebba_cli.project.build_images import ANGLE_FACTORS, ImageRows
from splinebba_cli.project.build_observations import SIGMA_COLUMNS, group_name, read_measured
from splinebba_cli.project.chain_checks import check_chain_groups
from splinebba_cli.project.model_observations import ChainGroup
from splinebba_cli.project.photo_directions import directions_in_photo
from splinebba_cli.project.plain_text import id_problem
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

DIRECTIONS = ("direction", "normal_x", "normal_y")
NO_CHAIN = ("", "-")  # fields of single points in a column of chains
CHAIN_COLUMNS = Wanted(("image", "x", "y"), ("chain", *DIRECTIONS, *SIGMA_COLUMNS, "use"))


@dataclass(frozen=True)
class ChainGroupRows:
    """Unlabelled points of one group, row by row of its table."""

    table: Table
    name: str
    image: IntArray  # (n,)
    photo_xy: FloatArray  # (n, 2) mm
    sigma: FloatArray  # (n, 2) mm
    chain: IntArray  # (n,) number of the chain in the table, -1: single
    chain_ids: tuple[str, ...]  # "image/chain"
    direction: FloatArray  # (n,) rad in the photo frame, NaN unknown
    excluded: BoolArray  # (n,)


@dataclass
class ChainRows:
    """All groups of unlabelled points."""

    groups: list[ChainGroupRows] = field(default_factory=list)

    @property
    def points(self) -> int:
        """Number of points, without those that the user has taken out."""
        return sum(int((~group.excluded).sum()) for group in self.groups)

    @property
    def image(self) -> IntArray:
        """Image of every point, (n,)."""
        parts = [group.image for group in self.groups]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)


def read_chains(building: Building, images: ImageRows, frames: list[PhotoFrame]) -> ChainRows:
    """All unlabelled points of the project."""
    rows = ChainRows()
    for number, group in enumerate(building.model.observations.chains):
        path: YamlPath = ("observations", "chains", number)
        table = building.reader.read(group, path, CHAIN_COLUMNS)
        if table is None:
            building.unread.add("observations")
            continue
        measured = read_measured(table, group, path, building, images, frames)
        chain, ids = _chains(table, building)
        direction = _directions(table, group, path, building)
        rows.groups.append(
            ChainGroupRows(
                table=table,
                name=group_name(group, path),
                image=measured.image,
                photo_xy=measured.photo_xy,
                sigma=measured.sigma,
                chain=chain,
                chain_ids=ids,
                direction=directions_in_photo(direction, group, measured.image, images, frames),
                excluded=table.excluded(),
            )
        )
    _check_one_table(rows, building)
    check_chain_groups(building, rows.groups)
    return rows


def _chains(table: Table, building: Building) -> tuple[IntArray, tuple[str, ...]]:
    """Number of the chain of every row, (n,), and ids of the chains; their rows must stand together."""
    if not table.has("chain"):
        return np.full(table.rows, -1, dtype=np.int64), ()
    words = table.words("chain")
    _check_names(table, building)
    single = np.array([name in NO_CHAIN for name in words.names], dtype=bool)[words.number]
    images = table.labels("image")
    key = images.number * len(words.names) + words.number
    begins = np.concatenate([[True], key[1:] != key[:-1]]) & ~single
    _, first, chain = np.unique(key[begins], return_index=True, return_inverse=True)
    starts = np.flatnonzero(begins)
    for row in np.delete(starts, first):
        message = f"rows of chain `{words[int(row)]}` of one image do not stand together"
        help = "sort the table by image and chain, and keep the order of tracing inside of a chain"
        place = table.place_of(int(row), "chain")
        building.collector.error("SBB328", message, place, help, kind="chains in several parts")
    of_run = np.full(table.rows, -1, dtype=np.int64)
    of_run[starts] = chain
    run = np.maximum.accumulate(np.where(begins, np.arange(table.rows), -1))
    number = np.where(single, -1, of_run[run])
    ids = [f"{images[int(row)]}/{words[int(row)]}" for row in starts[first]]
    return number, tuple(ids)


def _check_names(table: Table, building: Building) -> None:
    words = table.words("chain")
    for number, name in enumerate(words.names):
        if name not in NO_CHAIN and (problem := id_problem(name)):
            row = int(np.flatnonzero(words.number == number)[0])
            building.collector.error(
                "SBB210", f"`chain` {problem}", table.place_of(row, "chain"), kind="bad names of chains"
            )


def _directions(table: Table, group: ChainGroup, path: YamlPath, building: Building) -> FloatArray:
    """Directions in the image coordinates of the group, (n,) rad; NaN where they are not given."""
    given = [name for name in DIRECTIONS if table.has(name)]
    place = building.source.place(path)
    if not given:
        return np.full(table.rows, np.nan)
    if "direction" in given and len(given) > 1:
        message = "`direction` and a normal both given"
        building.collector.error("SBB209", message, place, "the normal is across the edge: give one of them")
        return np.full(table.rows, np.nan)
    if "direction" in given:
        unit = group.angle_unit or building.model.project.angle_unit
        if unit is None:
            help = "angle_unit: deg, gon or rad, here or in `project`"
            building.collector.error("SBB202", "directions without a unit", place, help)
        return table.numbers("direction", optional=True) * ANGLE_FACTORS[unit or "deg"]
    if len(given) == 1:
        lacking = "normal_y" if given == ["normal_x"] else "normal_x"
        building.collector.error("SBB402", f"`{given[0]}` without `{lacking}`", place)
        return np.full(table.rows, np.nan)
    normal_x, normal_y = (table.numbers(name, optional=True) for name in DIRECTIONS[1:])
    for row in np.flatnonzero((normal_x == 0.0) & (normal_y == 0.0)):
        place = table.place_of(int(row), "normal_x")
        help = "leave both fields empty where the normal is not known"
        building.collector.error("SBB403", "a normal of length 0", place, help, kind="normals of length 0")
    return np.asarray(np.arctan2(normal_x, -normal_y))  # a quarter of a turn from the normal


def _check_one_table(rows: ChainRows, building: Building) -> None:
    """A chain stands in one table: the same name in two of them would be two chains of one name."""
    seen: dict[tuple[str, str], int] = {}
    for number, group in enumerate(rows.groups):
        if len(rows.groups) == 1 or not group.chain_ids:
            continue
        images, names = group.table.labels("image"), group.table.words("chain")
        _, first = np.unique(group.chain, return_index=True)
        for row in first[group.chain[first] >= 0].tolist():
            image, name = images[row], names[row]
            if seen.setdefault((image, name), number) != number:
                message = f"chain `{name}` of image `{image}` stands in two tables"
                help = "give the chains of one of them other names"
                place = group.table.place_of(row, "chain")
                building.collector.error("SBB328", message, place, help, kind="chains in two tables")


def as_unlabelled_points(rows: ChainRows) -> UnlabelledPoints:
    """Unlabelled points for the core, group by group in the order of their tables."""
    groups = rows.groups
    if not groups:
        return UnlabelledPoints.none()
    starts = np.cumsum([0, *(len(group.chain_ids) for group in groups)])
    chains = [np.where(g.chain >= 0, g.chain + start, -1) for g, start in zip(groups, starts, strict=False)]
    excluded = np.concatenate([group.excluded for group in groups])
    return UnlabelledPoints(
        image=rows.image,
        photo_xy=stacked([group.photo_xy for group in groups], 2),
        sigma=stacked([group.sigma for group in groups], 2),
        chain=np.concatenate(chains),
        direction=np.concatenate([group.direction for group in groups]),
        chain_ids=tuple(id for group in groups for id in group.chain_ids),
        group=np.concatenate([np.full(len(g.image), k, dtype=np.int64) for k, g in enumerate(groups)]),
        group_names=tuple(group.name for group in groups),
        excluded=excluded if excluded.any() else None,
    )
