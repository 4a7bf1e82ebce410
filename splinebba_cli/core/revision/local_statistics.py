"""Standardised residuals of all measurements, whatever weight each of them had.

A measurement of variance sigma^2 that took part with the factor p of its weight, and whose row has the leverage
h = a Q a' / sigma^2 in the network so weighted, has a residual of variance

    sigma^2 q,    q = 1 + (1 - 2p) h - p (1 - p) h^2,

which is 1 - h (its redundancy number) for p = 1 and 1 + h, the variance of a prediction, for p = 0.  (The other
measurements count as if their weights were true.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.redundancy import RedundancyNumbers, redundancy_numbers
from splinebba_cli.core.revision.observation_list import CURVES, ObservationList
from splinebba_cli.core.revision.observation_weights import FAINT
from splinebba_cli.core.settings import TestStatistic

LEAST_REDUNDANCY = 0.01
"""Below it no measurement is tested: its residual shows less than a hundredth of its error, so that effects of the
linearisation decide; without it, its place in the network would have a variance of more than 100 sigma^2."""
LOST = 1.0 / LEAST_REDUNDANCY
"""Leverage beyond which a measurement that is out is not predicted by the others."""


@dataclass(frozen=True)
class LocalStatistics:
    """Residuals of the list; two values an entry: x and y of points, across and along curves, one of scalars."""

    residual: FloatArray  # (N, 2) over the given sigma; 0 where there is none
    leverage: FloatArray  # (N, 2) h
    standardized: FloatArray  # (N, 2) residual / sqrt(q); NaN where it is not testable
    redundancy: float  # of what takes part
    sigma0: float  # a posteriori over a priori, of what takes part; 1 without redundancy

    @property
    def tests(self) -> int:
        """Number of values that can be tested."""
        return int(np.isfinite(self.standardized).sum())

    def largest(self, statistic: TestStatistic) -> FloatArray:
        """Largest |w| or |tau| of every entry, (N,); 0 where nothing is testable."""
        own = np.nan_to_num(np.abs(self.standardized)).max(axis=1, initial=0.0)
        return np.asarray(own if statistic == "w" else own / self.sigma0)


def local_statistics(
    listed: ObservationList, factor: FloatArray, solved: ConditionedSolution
) -> LocalStatistics:
    """Statistics of a solution with the factors (N,) of :func:`~.observation_weights.faintly_weighted`."""
    cofactors = Cofactors(solved.assembler, solved.solution)
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    whitened, redundancy, has = _rows(listed, solved, numbers)
    weight = np.maximum(factor, FAINT)[:, None]
    residual, leverage = whitened / np.sqrt(weight), (1.0 - redundancy) / weight
    p = factor[:, None]
    variance = 1.0 + (1.0 - 2.0 * p) * leverage - p * (1.0 - p) * leverage**2
    known = np.where(p > 0.0, variance > LEAST_REDUNDANCY, leverage < LOST) & has
    standardized = np.where(known, residual / np.sqrt(np.where(known, variance, 1.0)), np.nan)
    out = factor == 0.0
    r = numbers.total - float(redundancy[out].sum())
    cost = solved.solution.linearization.cost - float(np.sum(whitened[out] ** 2))
    sigma0 = float(np.sqrt(cost / r)) if r > 0.5 and cost > 0.0 else 1.0
    return LocalStatistics(residual, np.where(has, leverage, 0.0), standardized, r, sigma0)


def _rows(
    listed: ObservationList, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Whitened residuals, redundancy numbers, and where there is one, (N, 2) each."""
    at = solved.solution.linearization
    whitened, redundancy = np.zeros((len(listed), 2)), np.zeros((len(listed), 2))
    has = np.zeros((len(listed), 2), dtype=bool)
    points = len(at.points.residual)
    whitened[:points], redundancy[:points], has[:points] = at.points.residual, numbers.image_points, True
    count = len(at.curve.speed)
    own, own_r, own_has = (listed.part(values, CURVES) for values in (whitened, redundancy, has))
    own[:, 0], own_r[:, 0], own_has[:, 0] = at.curve.residual[:count], numbers.curve_rows[:count], True
    held = at.curve.point[count:]
    own[held, 1], own_r[held, 1], own_has[held, 1] = (
        at.curve.residual[count:],
        numbers.curve_rows[count:],
        True,
    )
    linked = np.flatnonzero(solved.assembler.prepared.chains.linked)
    own[linked, 1], own_r[linked, 1], own_has[linked, 1] = (
        at.linked.along[linked],
        numbers.linked_along[linked],
        True,
    )
    scalars = listed.starts[CURVES + 1]
    whitened[scalars:, 0] = np.concatenate(
        [at.linked.arc_residual, at.linked.tangent_residual, at.distances.residual]
    )
    redundancy[scalars:, 0] = np.concatenate([numbers.arc_lengths, numbers.tangents, numbers.distances])
    has[scalars:, 0] = True
    return whitened, redundancy, has
