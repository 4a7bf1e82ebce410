"""Rejections of a run written into the column `use` of the observation tables: a run that is repeated keeps them.

A table with a rejected row is written anew under the program's column names, with all that was in it; rows that the
user has taken out stay out.  To bring an observation back, change its `no` to `yes`.  Features that were left out of
the adjustment are not in the adjusted project, and neither are the rows that measure them.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import compress
from typing import Any

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.project.build_distances import DISTANCE_COLUMNS
from splinebba_cli.project.build_linked import ARC_COLUMNS, TANGENT_COLUMNS
from splinebba_cli.project.build_observations import POINT_COLUMNS, SPLINE_COLUMNS
from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.network_tables import csv_text, number
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import TableReader, Wanted
from splinebba_cli.project.yaml_source import read_yaml

KINDS: dict[str, tuple[Wanted, str]] = {
    "spline_points": (SPLINE_COLUMNS, "spline"),
    "points": (POINT_COLUMNS, "point"),
    "arc_lengths": (ARC_COLUMNS, "spline"),
    "tangents": (TANGENT_COLUMNS, "spline"),
    "distances": (DISTANCE_COLUMNS, ""),
}  # section of the project: columns, and the one that names a feature that may take no part

LEFT_OUT = ("SBB304", "SBB310")  # codes of the warnings about features that take no part


def marked_tables(
    loaded: LoadedProject, result: AdjustmentResult, left_out: frozenset[str] = frozenset()
) -> dict[tuple[str, int], str]:
    """Tables (CSV) of the groups in which the run rejected or left out something, by section and number of the group.

    Empty where all that a group measures is left out.

    Parameters
    ----------
    left_out : columns of the user's tables that are not written
    """
    weights = rejected_rows(result)
    if not any(rows.any() for rows in weights.values()) and not _leaves_features_out(loaded):
        return {}
    source = read_yaml(loaded.path, Collector())
    if source is None:
        return {}
    reader = TableReader(source, loaded.path.parent, Collector(), loaded.model.project.table_folders)
    found = {}
    for key, (wanted, feature) in KINDS.items():
        for group, table, rows in _tables(loaded, reader, key, wanted, feature):
            known = rows >= 0
            rejected = np.zeros(table.rows, dtype=bool)
            rejected[known] = weights[key][rows[known]]
            if rejected.any() or not known.all():
                marked = _written(table, known, rejected | table.excluded(), left_out)
                found[key, group] = marked if known.any() else ""
    return found


def _leaves_features_out(loaded: LoadedProject) -> bool:
    """Whether points or splines that too few images see were left out with a warning."""
    return any(diagnostic.code in LEFT_OUT for diagnostic in loaded.diagnostics)


def rejected_rows(result: AdjustmentResult) -> dict[str, BoolArray]:
    """Rows of every section that the run has rejected."""
    network, revision = result.network, result.revision

    def rows(weight: FloatArray | None, excluded: BoolArray | None, count: int) -> BoolArray:
        gone = np.zeros(count, dtype=bool) if weight is None else weight == 0.0
        return gone if excluded is None else gone & ~excluded

    curves, points = network.curve_observations, network.point_observations
    arcs, tangents, distances = network.arc_lengths, network.tangents, network.distances
    return {
        "spline_points": rows(revision.curve_weights, curves.excluded, len(curves)),
        "points": rows(revision.point_weights, points.excluded, len(points)),
        "arc_lengths": rows(revision.arc_weights, arcs.excluded, len(arcs)),
        "tangents": rows(revision.tangent_weights, tangents.excluded, len(tangents)),
        "distances": rows(revision.distance_weights, distances.excluded, len(distances)),
    }


def _tables(
    loaded: LoadedProject, reader: TableReader, key: str, wanted: Wanted, feature: str
) -> Iterator[tuple[int, Table, IntArray]]:
    """Group, its table, and the network's row of every row of it; -1 for features that take no part."""
    network: Network = loaded.network
    ids = set(network.points.ids) if feature == "point" else {curve.id for curve in network.curves}
    begin = 0
    groups: Any = getattr(loaded.model.observations, key)
    for number_, group in enumerate(groups):
        table = reader.read(group, ("observations", key, number_), wanted)
        if table is None:
            continue
        kept = np.ones(table.rows, dtype=bool)
        if feature:
            kept = np.array([name in ids for name in table.texts(feature)], dtype=bool)
        rows = np.where(kept, begin + np.cumsum(kept) - 1, -1)
        begin += int(kept.sum())
        yield number_, table, rows


def _written(table: Table, kept: BoolArray, out: BoolArray, left_out: frozenset[str]) -> str:
    names = [name for name in table.columns if name != "use" and name not in left_out]
    columns = [
        [number(v) if isinstance(v, float) else str(v) for v in _values(table, name)] for name in names
    ]
    use = ["no" if gone else "yes" for gone in out]
    rows = zip(*columns, use, strict=True)
    return csv_text([*names, "use"], compress(rows, kept))


def _values(table: Table, name: str) -> list[Any]:
    values: Any = table.columns[name]
    return values.tolist() if isinstance(values, np.ndarray) else list(values)
