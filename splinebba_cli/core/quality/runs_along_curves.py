"""Runs of residuals along curves: the correlation of neighbours, in the order of their locations, in one image.

With r the whitened residuals across one curve, r ~ N(0, s^2 R), S = r'L r = sum of products of neighbours,

    rho0 = tr(L R) / tr R     what the adjustment itself makes (slightly negative)
    T    = r'(L - rho0 I) r,   E T = 0,   var T = 2 s^4 tr((L' R)^2),   L' = L - rho0 I
    z    = T / (s^2 sqrt(2 tr((L' R)^2))),   s^2 = r'r / tr R            standard normal without runs

one-sided: neighbours that agree.  R = I - A Q A' of the curve is exact where that is affordable; beyond, rho0 = 0 and
tr((L R)^2) <= tr(L^2) make the test conservative.  (von Neumann 1941; Durbin & Watson 1950)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.row_groups import split_by

FEWEST_PAIRS = 20
MOST_ROWS = 3000  # of a curve whose R is formed


@dataclass(frozen=True)
class _Run:
    curve: int
    rows: int
    z: float
    correlation: float  # beyond rho0
    images: int


def runs_along_curves(
    projector: ResidualProjector, rows: PhotoRows, redundancy: FloatArray
) -> list[SystematicEffect]:
    """Tests of all curves with enough neighbours; alpha belongs to all curves together.

    Parameters
    ----------
    redundancy : (n,) redundancy numbers across
    """
    network = projector.assembler.prepared.network
    budget, found = projector.affordable, []
    across = np.flatnonzero(rows.across)
    for curve, member in enumerate(split_by(rows.curve[across], len(network.curves))):
        own = across[member]
        order = np.lexsort((projector.solution.state.location[own], rows.image[own]))
        own = own[order]
        first = neighbours(rows.image[own])
        if len(first) < FEWEST_PAIRS or redundancy[own].sum() <= 1.0:
            continue
        moments = (0.0, 0.5 * len(first), float(redundancy[own].sum()))
        if budget > 0 and len(own) <= MOST_ROWS:
            unknowns = np.unique(projector.design.reduced[own].indices).astype(np.int64)
            if len(unknowns) <= budget:
                moments = _moments(first, _residual_cofactors(projector, own, unknowns))
            budget -= len(unknowns)
        found.append(_run(curve, rows, own, first, moments))
    return [_effect(run, len(found), network.curves[run.curve].id, network.settings.alpha) for run in found]


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


def _run(
    curve: int, rows: PhotoRows, own: IntArray, first: IntArray, moments: tuple[float, float, float]
) -> _Run:
    rho, square, trace = moments
    r = rows.residual[own]
    variance = float(r @ r) / trace
    t = float(r[first] @ r[first + 1]) - rho * float(r @ r)
    images = len(np.unique(rows.image[own]))
    if variance <= 0.0:
        return _Run(curve, len(own), 0.0, 0.0, images)
    return _Run(
        curve,
        len(own),
        t / (variance * np.sqrt(2.0 * square)),
        t / (variance * len(first)),
        images,
    )


def _effect(run: _Run, tests: int, name: str, alpha: float) -> SystematicEffect:
    critical = float(ndtri(1.0 - single_alpha(alpha, "sidak", tests)))
    probability = float(-np.expm1(tests * np.log1p(-min(float(ndtr(-run.z)), 1.0 - 1e-16))))
    return SystematicEffect(
        kind="run along curve",
        subject=f"spline `{name}`",
        estimate=run.correlation,
        unit="",
        statistic=run.z,
        critical=critical,
        significant=bool(run.z > critical),
        observations=run.rows,
        detail=f"in {run.images} images",
        probability=probability,
    )
