"""Runs of residuals along curves: the correlation of neighbours, in the order of their locations, in one image.

With r the whitened residuals across one curve, r ~ N(0, s^2 R), S = r'L r = sum of products of neighbours,

    rho0 = tr(L R) / tr R     what the adjustment itself makes (slightly negative)
    T    = r'(L - rho0 I) r,   E T = 0,   var T = 2 s^4 tr((L' R)^2),   L' = L - rho0 I
    z    = T / (s^2 sqrt(2 tr((L' R)^2))),   s^2 = r'r / tr R            standard normal without runs

one-sided: neighbours that agree.  R = I - A Q A' of the curve is exact where that is affordable; beyond, rho0 = 0 and
tr((L R)^2) <= tr(L^2) make the test conservative.  (von Neumann 1941; Durbin & Watson 1950)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector

FEWEST_PAIRS = 20
MOST_ROWS = 3000  # of a curve whose R is formed


@dataclass(frozen=True)
class _Runs:
    """Curves with enough neighbours; rows sorted by curve, image and location."""

    curve: IntArray  # (c,)
    begin: IntArray  # (c,) first of its rows
    end: IntArray  # (c,)
    order: IntArray  # (n,) rows, curve by curve
    square: FloatArray  # (c,) r'r
    product: FloatArray  # (c,) sum of products of neighbours
    pairs: IntArray  # (c,) neighbours
    redundancy: FloatArray  # (c,) sum of redundancy numbers
    images: IntArray  # (c,)

    def rows(self, number: int) -> IntArray:
        """Rows of one of them."""
        return self.order[self.begin[number] : self.end[number]]


def runs_along_curves(
    projector: ResidualProjector, rows: PhotoRows, redundancy: FloatArray
) -> list[SystematicEffect]:
    """Tests of all curves with enough neighbours; alpha belongs to all curves together.

    Parameters
    ----------
    redundancy : (n,) redundancy numbers across
    """
    runs = _runs(projector, rows, redundancy)
    rho, square, trace = np.zeros(len(runs.curve)), 0.5 * runs.pairs, runs.redundancy.copy()
    for number, moments in _exact_moments(projector, rows, runs):
        rho[number], square[number], trace[number] = moments
    variance = runs.square / trace
    known = variance > 0.0
    t = runs.product - rho * runs.square
    z = np.divide(t, variance * np.sqrt(2.0 * square), out=np.zeros(len(t)), where=known)
    correlation = np.divide(t, variance * runs.pairs, out=np.zeros(len(t)), where=known)
    return _effects(projector.assembler.prepared.network, runs, z, correlation)


def _runs(projector: ResidualProjector, rows: PhotoRows, redundancy: FloatArray) -> _Runs:
    across = np.flatnonzero(rows.across)
    location = projector.solution.state.location[across]
    order = across[np.lexsort((location, rows.image[across], rows.curve[across]))]
    curve, image, residual = rows.curve[order], rows.image[order], rows.residual[order]
    count = len(projector.assembler.prepared.network.curves)
    same = curve[1:] == curve[:-1]
    first = np.flatnonzero(same & (image[1:] == image[:-1]))
    pairs = np.bincount(curve[first], minlength=count)
    product = np.asarray(
        np.bincount(curve[first], residual[first] * residual[first + 1], minlength=count), dtype=np.float64
    )
    control = np.asarray(np.bincount(curve, redundancy[order], minlength=count), dtype=np.float64)
    square = np.asarray(np.bincount(curve, residual**2, minlength=count), dtype=np.float64)
    bounds = np.searchsorted(curve, np.arange(count + 1))
    switches = np.bincount(curve[1:][same & (image[1:] != image[:-1])], minlength=count)
    chosen = np.flatnonzero((pairs >= FEWEST_PAIRS) & (control > 1.0))
    return _Runs(
        chosen, bounds[chosen], bounds[chosen + 1], order,
        square[chosen], product[chosen], pairs[chosen],
        control[chosen], switches[chosen] + 1,
    )  # fmt: skip


def _sums(curve: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Sums of values curve by curve, (count,)."""
    return np.asarray(np.bincount(curve, values, minlength=count), dtype=np.float64)


def _exact_moments(
    projector: ResidualProjector, rows: PhotoRows, runs: _Runs
) -> Iterator[tuple[int, tuple[float, float, float]]]:
    """rho0, tr((L' R)^2) and tr R of the first curves, as many as are affordable."""
    budget = projector.affordable
    for number in range(len(runs.curve)):
        if budget <= 0:
            return
        own = runs.rows(number)
        if len(own) <= MOST_ROWS:
            unknowns = np.unique(projector.design.reduced[own].indices).astype(np.int64)
            if len(unknowns) <= budget:
                cofactors = _residual_cofactors(projector, own, unknowns)
                yield number, _moments(neighbours(rows.image[own]), cofactors)
            budget -= len(unknowns)


def neighbours(image: IntArray) -> IntArray:
    """The first of all pairs (first, first + 1) in one image."""
    return np.flatnonzero(image[1:] == image[:-1])


def _residual_cofactors(projector: ResidualProjector, own: IntArray, unknowns: IntArray) -> FloatArray:
    """R of the rows of one curve, (n, n)."""
    local = projector.design.reduced[own][:, unknowns].toarray()
    return np.asarray(np.eye(len(own)) - local @ projector.cofactors(unknowns) @ local.T)


def _moments(first: IntArray, cofactors: FloatArray) -> tuple[float, float, float]:
    """rho0, tr((L' R)^2), tr R; L has one half at all neighbours (first, first + 1)."""
    trace = float(np.trace(cofactors))
    product = np.zeros_like(cofactors)
    product[first] += 0.5 * cofactors[first + 1]
    product[first + 1] += 0.5 * cofactors[first]
    rho = float(np.trace(product)) / trace
    product -= rho * cofactors
    return rho, float(np.sum(product * product.T)), trace


def _effects(network: Network, runs: _Runs, z: FloatArray, correlation: FloatArray) -> list[SystematicEffect]:
    tests = len(runs.curve)
    if not tests:
        return []
    critical = float(ndtri(1.0 - single_alpha(network.settings.alpha, "sidak", tests)))
    probability = -np.expm1(tests * np.log1p(-np.minimum(ndtr(-z), 1.0 - 1e-16)))
    columns = (runs.curve, correlation, z, probability, runs.end - runs.begin, runs.images)
    return [
        SystematicEffect(
            kind="run along curve",
            subject=f"spline `{network.curves[curve].id}`",
            estimate=estimate,
            unit="",
            statistic=statistic,
            critical=critical,
            significant=statistic > critical,
            observations=count,
            detail=f"in {images} images",
            probability=chance,
        )
        for curve, estimate, statistic, chance, count, images in zip(
            *(column.tolist() for column in columns), strict=True
        )
    ]
