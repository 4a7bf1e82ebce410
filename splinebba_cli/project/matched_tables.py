"""Tables of matched and unmatched points, group by group, in the frame and unit of the user's tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from splinebba_cli.core.matching.matches import MatchResult, Reason
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.project.build_chains import CHAIN_COLUMNS, DIRECTIONS
from splinebba_cli.project.build_observations import SIGMA_COLUMNS
from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.network_tables import csv_text, numbers
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import TableReader
from splinebba_cli.project.yaml_source import read_yaml

FIGURES = "{:.3g}"  # distances in σ: no more digits than they are worth


@dataclass(frozen=True)
class ChainTable:
    """One group of chains: the user's table, and what was found for every row."""

    name: str
    table: Table
    image: IntArray  # (n,)
    matched: BoolArray  # (n,)
    spline: tuple[str, ...]  # (n,) empty where none
    location: FloatArray  # (n,) NaN where unmatched
    distance: FloatArray  # (n,) over its σ
    runner_up: FloatArray  # (n,)
    reason: tuple[str, ...]  # (n,)

    def has(self, column: str) -> bool:
        """Whether the user's table has a column."""
        return self.table.has(column)

    def matched_text(self, *, marked: bool) -> str:
        """Table (CSV) of the matched points; `marked`: with names of points, where others refer to some by number."""
        rows = np.flatnonzero(self.matched)
        columns = {
            "image": self._texts("image", rows),
            "spline": _chosen(self.spline, rows),
            **self._given(rows, "x", "y", *SIGMA_COLUMNS),
            "location": numbers(self.location[rows]),
            **self._given(rows, "use"),
        }
        if marked:
            columns["mark"] = [f"{self.name}-{row + 1}" for row in rows.tolist()]
        return _csv(columns | self._given(rows, "chain") | self._distances(rows))

    def unmatched_text(self) -> str:
        """Table (CSV) of the unmatched points with the reason of each."""
        rows = np.flatnonzero(~self.matched)
        reason = {"reason": _chosen(self.reason, rows)}
        return _csv(self._given(rows, *_AS_GIVEN) | reason | self._distances(rows))

    def chains_text(self, rows: BoolArray) -> str:
        """Table (CSV) of points as they were given."""
        return _csv(self._given(np.flatnonzero(rows), *_AS_GIVEN))

    def _given(self, rows: IntArray, *names: str) -> dict[str, list[str]]:
        return {name: self._texts(name, rows) for name in names if self.table.has(name)}

    def _distances(self, rows: IntArray) -> dict[str, list[str]]:
        return {"distance": _figures(self.distance[rows]), "runner_up": _figures(self.runner_up[rows])}

    def _texts(self, name: str, rows: IntArray) -> list[str]:
        values: Any = self.table.columns[name]
        if isinstance(values, np.ndarray):
            return numbers(values[rows])
        return [str(value).strip() for value in _chosen(values, rows)]


_AS_GIVEN = ("image", "chain", "x", "y", *DIRECTIONS, *SIGMA_COLUMNS, "use")


def matched_columns(table: ChainTable, *, marked: bool) -> list[str]:
    """Columns of the table of matched points that a project reads."""
    sigmas = [name for name in SIGMA_COLUMNS if table.has(name)]
    use = ["use"] if table.has("use") else []
    return ["image", "spline", "x", "y", *sigmas, "location", *use, *(["mark"] if marked else [])]


def chain_tables(loaded: LoadedProject, result: MatchResult) -> list[ChainTable]:
    """The groups of chains of a project with what was found, in their order."""
    source = read_yaml(loaded.path, Collector())
    if source is None:
        return []
    reader = TableReader(source, loaded.path.parent, Collector(), loaded.model.project.table_folders)
    points, found = result.given.unlabelled, result.matches
    ids = np.array([*(curve.id for curve in result.network.curves), ""], dtype=object)
    words = np.array([reason_word(reason) for reason in Reason], dtype=object)
    out, begin = [], 0
    for number_, group in enumerate(loaded.model.observations.chains):
        table = reader.read(group, ("observations", "chains", number_), CHAIN_COLUMNS)
        if table is None:
            continue
        rows = slice(begin, begin + table.rows)
        begin += table.rows
        curve = found.curve[rows]
        out.append(
            ChainTable(
                name=points.group_names[number_],
                table=table,
                image=points.image[rows],
                matched=curve >= 0,
                spline=tuple(ids[curve]),
                location=found.location[rows],
                distance=found.distance[rows],
                runner_up=found.runner_up[rows],
                reason=tuple(words[found.reason[rows]]),
            )
        )
    return out


def reason_word(reason: int) -> str:
    """The word for a reason: ``far``, ``not oriented``."""
    return Reason(reason).name.lower().replace("_", " ")


def _figures(values: FloatArray) -> list[str]:
    """Numbers with three digits; empty where infinite or missing."""
    return [FIGURES.format(value) if np.isfinite(value) else "" for value in values.tolist()]


def _chosen(values: Sequence[str], rows: IntArray) -> list[str]:
    return [values[row] for row in rows.tolist()]


def _csv(columns: dict[str, list[str]]) -> str:
    return csv_text(list(columns), zip(*columns.values(), strict=True))
