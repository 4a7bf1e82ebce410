"""Which splines of a table are as usual, so that what one of them passed need not be asked of each.

Splines of a table share their options.  One whose rows are finite, different from their neighbours and have the σ
of their role is right if another one with as many rows is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.project.model_features import SplineTable


@dataclass
class UsualRows:
    """What is known about the splines of a table, and what was learnt of those that were checked."""

    sigma: FloatArray  # (n, 3) of the rows, where none is given that of the role
    scattered: BoolArray  # (s,) whether the rows of a spline lie apart
    plain: BoolArray  # (s,) whether nothing but its number of rows may be wrong
    rows: IntArray  # (s,) number of rows
    right: set[int] = field(default_factory=set)  # numbers of rows that a checked spline had

    @classmethod
    def of(
        cls,
        entry: SplineTable,
        values: FloatArray,
        sigma: FloatArray,
        parameters: FloatArray | None,
        taken: Sequence[IntArray],
    ) -> UsualRows:
        """Look at all splines of a table at once.

        Parameters
        ----------
        values, sigma : (n, 3)
        parameters : (n,) of the knots, or None
        taken : sequence of (k,)
            Rows of every spline, none empty.
        """
        count = np.array([len(rows) for rows in taken], dtype=np.int64)
        order = np.concatenate(taken) if len(taken) else np.empty(0, dtype=np.int64)
        starts = np.cumsum(count) - count
        last = starts + count - 1
        free = entry.role in ("tie", "partial", "check")
        plain = np.full(len(taken), FAMILIES[entry.family].rows == "points" and entry.role != "check")
        if len(taken):
            ordered, given = values[order], sigma[order]
            plain &= ~_any(np.isnan(ordered).any(axis=1), starts)
            step = np.diff(ordered, axis=0, append=np.inf)
            step[last] = ordered[starts] - ordered[last] if entry.closed else 1.0
            plain &= ~_any((step == 0.0).all(axis=1), starts)
            plain &= _sigma_of_role(entry.role, given, starts)
            if parameters is not None:
                further = np.diff(parameters[order], append=np.inf)
                further[last] = 1.0
                plain &= ~_any(~(further > 0.0), starts)
        filled = np.where(np.isnan(sigma), np.inf if free else 0.0, sigma)
        return cls(filled, order[last] - order[starts] != count - 1, plain, count)

    def is_usual(self, number: int) -> bool:
        """Whether a spline need not be checked."""
        return bool(self.plain[number]) and int(self.rows[number]) in self.right

    def checked(self, number: int, right: bool) -> None:
        """Take note of what a check has found."""
        if right and self.plain[number]:
            self.right.add(int(self.rows[number]))


def _sigma_of_role(role: str, sigma: FloatArray, starts: IntArray) -> BoolArray:
    """Whether a spline has the σ that its role needs, (s,)."""
    if role == "control":
        return ~_any(~np.isfinite(sigma).all(axis=1), starts)
    given = _any(np.isfinite(sigma).any(axis=1), starts)
    return given if role == "partial" else ~given


def _any(rows: BoolArray | np.bool_, starts: IntArray) -> BoolArray:
    return np.asarray(np.logical_or.reduceat(np.atleast_1d(rows), starts))
