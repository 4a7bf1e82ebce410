"""What the builders of the network share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.diagnostics import Collector, Place, listing, suggestion
from splinebba_cli.project.model import Project
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import TableReader
from splinebba_cli.project.yaml_source import YamlSource

Purpose = Literal["adjustment", "simulation", "matching"]
"""What a project is read for: one to be simulated may lack the observations that `simulate` places itself, one to be
matched those that `match` finds among its chains."""


FEATURES = frozenset({"camera", "image", "spline", "point"})


@dataclass
class Building:
    """The model, where it stands, and where to complain."""

    model: Project
    source: YamlSource
    reader: TableReader
    collector: Collector
    purpose: Purpose = "adjustment"
    unread: set[str] = field(
        default_factory=set
    )  # kinds of features and of observations with an unreadable table
    _said: set[str] = field(default_factory=set)

    def first_time(self, key: str) -> bool:
        """Whether something is to be said for the first time."""
        new = key not in self._said
        self._said.add(key)
        return new

    def duplicate(self, kind: str, id: str, place: Place, first_line: int | None) -> None:
        """Report a second thing with the same id."""
        help = f"first given in line {first_line}" if first_line else ""
        self.collector.error("SBB302", f"{kind} `{id}` given twice", place, help, kind=f"{kind}s given twice")

    def unknown(self, kind: str, id: str, place: Place, known: Iterable[str]) -> None:
        """Report a reference to an id that is not declared."""
        known = list(known)
        if id.endswith(".0") and id[:-2] in known:
            help = (
                f"`{id[:-2]}` is declared: the table holds ids as floating point numbers, write them as texts"
            )
        else:
            help = suggestion(id, known) or (
                f"declared: {listing(known)}" if known else f"no {kind} is declared"
            )
        self.collector.error("SBB301", f"{kind} `{id}` is not declared", place, help, kind=f"unknown {kind}s")

    def indices(self, kind: str, table: Table, column: str, known: dict[str, int]) -> IntArray:
        """Indices of the ids in a column, (n,); -1 (and an error for each different one) where unknown.

        A declared id that is of no use (an error was reported) has the index -2.
        """
        labels = table.labels(column)
        index = np.array([known.get(name, -1) for name in labels.names], dtype=np.int64)
        found = index[labels.number] if len(index) else np.empty(0, dtype=np.int64)
        if (found == -1).any() and kind not in self.unread:
            number = labels.number[found == -1]
            rows = np.flatnonzero(found == -1)
            for first in np.sort(np.unique(number, return_index=True)[1]).tolist():
                name = labels.names[number[first]]
                if name:
                    self.unknown(kind, name, table.place_of(int(rows[first]), column), known)
        return found


def stacked(parts: Sequence[FloatArray], width: int) -> FloatArray:
    """Rows of several arrays under each other, (n, width), also where there is none."""
    if len(parts) == 1:
        return parts[0]
    return np.concatenate(parts) if parts else np.empty((0, width))
