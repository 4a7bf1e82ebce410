"""Chains that say two things: directions that do not follow them, points that are given twice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.project.build_context import Building

if TYPE_CHECKING:
    from splinebba_cli.project.build_chains import ChainGroupRows

FEWEST = 10  # points with a direction inside of chains, to judge a group by
BESIDE = np.radians(30.0)  # mean angle between directions and chains that no tracing explains
CLEARER = np.radians(5.0)  # mean angle by which another convention has to be better, and twice as good
TWICE = 0.01  # share of points that may be given twice by chance


def check_chain_groups(building: Building, groups: Sequence[ChainGroupRows]) -> None:
    """Warn where the columns of a group contradict each other."""
    for number, group in enumerate(groups):
        _check_directions(building, group, number)
        _check_copies(building, group)


def _check_directions(building: Building, group: ChainGroupRows, number: int) -> None:
    """SBB330: directions are compared with those from the point before to the point behind."""
    rows = _inner_rows(group.chain)
    rows = rows[np.isfinite(group.direction[rows]) & _counted(group)[rows]]
    if len(rows) < FEWEST:
        return
    step = group.photo_xy[rows + 1] - group.photo_xy[rows - 1]
    chain, given = np.arctan2(step[:, 1], step[:, 0]), group.direction[rows]
    normals = group.table.has("normal_x")
    quarter = "the normals" if not normals else "the directions"
    cures = {
        f"they are {quarter} of the edges": "direction is along the edge, normal_x and normal_y are across it",
        "they are mirrored": "angles count from x towards y of the image coordinates: clockwise where y points down",
        f"they are {quarter} of the edges, and mirrored": "direction is along the edge, normal_x and normal_y are "
        "across it; angles count from x towards y of the image coordinates",
    }
    others = (given + 0.5 * np.pi, -given, 0.5 * np.pi - given)
    found, best = _mean_angle(given, chain), [_mean_angle(angle, chain) for angle in others]
    likely, least = int(np.argmin(best)), min(best)
    if found < 2.0 * least + CLEARER:
        if found < BESIDE:
            return
        what, help = "", "are they of these points, in the unit and the frame that the group declares?"
    else:
        words = list(cures)[likely]
        what, help = f": {words}, it seems", cures[words]
    name = "normals" if normals else "directions"
    message = f"{name} of `{group.name}` do not follow the chains (mean angle {np.degrees(found):.0f}°){what}"
    place = building.source.place(("observations", "chains", number))
    building.collector.warning("SBB330", message, place, help)


def _counted(group: ChainGroupRows) -> BoolArray:
    """Rows that take part and could be read, (n,)."""
    return ~group.excluded & (group.image >= 0) & np.isfinite(group.photo_xy).all(axis=1)


def _inner_rows(chain: IntArray) -> IntArray:
    """Rows with a neighbour before and behind in their chain."""
    same = (chain[1:] == chain[:-1]) & (chain[1:] >= 0)
    return np.flatnonzero(same[1:] & same[:-1]) + 1


def _mean_angle(first: FloatArray, second: FloatArray) -> float:
    """Mean angle between lines without a sense, rad."""
    return float(np.mean(np.abs((first - second + 0.5 * np.pi) % np.pi - 0.5 * np.pi)))


def _check_copies(building: Building, group: ChainGroupRows) -> None:
    """SBB331: the same place of the same image in more than one row; a closed chain may end where it begins."""
    rows = np.flatnonzero(_counted(group) & ~_closing(group))
    x, y = group.photo_xy[rows].T
    order = rows[np.lexsort((rows, y, x, group.image[rows]))]
    same = group.image[order][1:] == group.image[order][:-1]
    same &= (group.photo_xy[order][1:] == group.photo_xy[order][:-1]).all(axis=1)
    copies = order[1:][same]
    if len(copies) <= TWICE * len(rows):
        return
    message = f"{len(copies)} of {len(rows)} points of `{group.name}` are given twice, the first of them here"
    help = "leave the copies out: a point that is given twice weighs twice, and standard deviations become too small"
    building.collector.warning("SBB331", message, group.table.place_of(int(copies.min()), "x"), help)


def _closing(group: ChainGroupRows) -> BoolArray:
    """Rows that end a chain where it begins, (n,)."""
    chain = group.chain
    out = np.zeros(len(chain), dtype=bool)
    if not len(chain):
        return out
    changes = np.flatnonzero(np.diff(chain)) + 1
    first, last = np.append(0, changes), np.append(changes, len(chain)) - 1
    same = (group.photo_xy[first] == group.photo_xy[last]).all(axis=1)
    out[last] = same & (first < last) & (chain[first] >= 0)
    return out
