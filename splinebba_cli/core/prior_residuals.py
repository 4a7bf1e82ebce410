"""Residuals v = adjusted - given of control coordinates, prior equations and conditions: one row an equation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

TextArray = npt.NDArray[np.object_]  # of str: equal ones share their text

ANGLES = ("omega", "phi", "kappa")  # components in radians, all others in metres


@dataclass(frozen=True)
class PriorResidual:
    """One of them."""

    kind: str  # "control point", "control spline", "eop prior", "gauge", "shape", "datum"
    subject: str  # id
    component: str  # "x", "omega", "knot 3 z"
    residual: float  # adjusted - given; m or rad
    sigma: float
    redundancy: float
    standardized: float = float("nan")  # v / (sigma0_prior sqrt(q_vv)); NaN of conditions
    minimal_detectable_bias: float = float("nan")  # m or rad; NaN of conditions
    bias_to_noise: float = float("nan")


_COLUMNS = tuple(field.name for field in fields(PriorResidual))


@dataclass(frozen=True)
class PriorResiduals:
    """All of them; the columns of :class:`PriorResidual`."""

    kind: TextArray  # (q,)
    subject: TextArray  # (q,)
    component: TextArray  # (q,)
    residual: FloatArray  # (q,)
    sigma: FloatArray  # (q,)
    redundancy: FloatArray  # (q,)
    standardized: FloatArray  # (q,)
    minimal_detectable_bias: FloatArray  # (q,)
    bias_to_noise: FloatArray  # (q,)

    @classmethod
    def of_rows(cls, rows: Sequence[PriorResidual]) -> PriorResiduals:
        """From single ones."""
        return cls(
            *(
                np.array([getattr(row, name) for row in rows], dtype=object if number < 3 else float)
                for number, name in enumerate(_COLUMNS)
            )
        )

    @property
    def angular(self) -> BoolArray:
        """Which of them are angles, (q,)."""
        return np.asarray(np.isin(self.component, np.array(ANGLES, dtype=object)))

    def groups(self) -> list[tuple[str, bool, IntArray]]:
        """Kind, whether angles, and rows, in the order in which they first appear."""
        kinds = {name: number for number, name in enumerate(dict.fromkeys(self.kind.tolist()))}
        key = 2 * np.array([kinds[name] for name in self.kind.tolist()], dtype=np.int64) + self.angular
        found, first = np.unique(key, return_index=True)
        names = list(kinds)
        return [
            (names[number // 2], bool(number % 2), np.flatnonzero(key == number))
            for number in found[np.argsort(first)].tolist()
        ]

    def __len__(self) -> int:
        return len(self.residual)

    def __getitem__(self, row: int) -> PriorResidual:
        texts, figures = _COLUMNS[:3], _COLUMNS[3:]
        return PriorResidual(
            *(getattr(self, name)[row] for name in texts),
            *(float(getattr(self, name)[row]) for name in figures),
        )

    def __iter__(self) -> Iterator[PriorResidual]:
        return map(PriorResidual, *(getattr(self, name).tolist() for name in _COLUMNS))
