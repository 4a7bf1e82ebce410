"""Check splines: at every given point the offset of the adjusted curve across it, against its predicted dispersion.

With the unit vectors E (3 x 2) of the normal plane at the foot point u and the basis weights N_j,

    d = E'(X(u) - X_given),   C = s0^2 sum_jl N_j N_l E'Q_jl E + sigma_given^2 I
    one point     d'C^-1 d                       2 degrees of freedom, Sidak's alpha of one of q tests
    together      S = sum_i d_i'C_ii^-1 d_i      2 q / f times chi-square of f = (2 q)^2 / |R|^2

R holds the covariances of all whitened offsets (2 q x 2 q).  Neighbours on a curve share its few coefficients, so
that the inverse of their joint dispersion does not exist, or would test how well the family fits the given shape to
micrometres: S tests sizes instead, with its mean 2 q and its variance 2 |R|^2 (Satterthwaite 1946; Box 1954).  The
single tests of correlated points are safe: see check_points.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.given_shape import given_points
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.joint_cofactors import cofactors_of, too_many
from splinebba_cli.core.quality.variance_factor import VarianceFactor
from splinebba_cli.core.result import CheckSpline, CheckTest

HELD = 1e-12  # m²: a smaller variance across belongs to a curve that is held there


@dataclass(frozen=True)
class Offsets:
    """Offsets of the adjusted curve from given points."""

    distance: FloatArray  # (q,) NaN beyond an end of an open curve
    inside: IntArray  # (p,) rows with a foot point
    u: FloatArray  # (p,) their foot points
    across: FloatArray  # (p, 3) adjusted - given, normal to the curve
    plane: FloatArray  # (p, 3, 2) unit vectors of the normal plane


def check_splines(cofactors: Cofactors, variance: VarianceFactor) -> tuple[CheckSpline, ...]:
    """Distances of the given points of check splines from the adjusted curves, normal to them, metres.

    Given points beyond an end of an open curve have no foot point on it: their distance is NaN.
    """
    curves = cofactors.assembler.prepared.network.curves
    return tuple(_one(cofactors, variance, k) for k, curve in enumerate(curves) if curve.role == "check")


def _one(cofactors: Cofactors, variance: VarianceFactor, k: int) -> CheckSpline:
    network = cofactors.assembler.prepared.network
    curve, found = network.curves[k], offsets_of(cofactors, k)
    count, alpha = len(found.u), network.settings.alpha
    if not count:
        nan = float("nan")
        return CheckSpline(curve.id, found.distance, nan, nan, nan)
    covariance = _dispersion(cofactors, k, found)
    together: CheckTest | None = None
    blocks = covariance[np.arange(count), :, np.arange(count), :] if covariance.ndim == 4 else covariance
    blocks = blocks * variance.scale + curve.check_sigma**2 * np.eye(2)
    offset = np.einsum("pik,pi->pk", found.plane, found.across)
    tested = np.linalg.eigvalsh(blocks)[:, 0] > HELD
    square = np.full(count, np.nan)
    square[tested] = np.einsum(
        "pi,pi->p", offset[tested], np.linalg.solve(blocks[tested], offset[tested][:, :, None])[:, :, 0]
    )
    critical = variance.critical(single_alpha(alpha, "sidak", int(tested.sum())), 2)
    if covariance.ndim == 4 and tested.any():
        root = np.linalg.inv(np.linalg.cholesky(blocks[tested]))
        joint = covariance[tested][:, :, tested] * variance.scale
        joint[np.arange(len(root)), :, np.arange(len(root)), :] = blocks[tested]
        whitened = np.einsum("pij,pjqk,qlk->piql", root, joint, root, optimize=True)
        together = _together(float(np.nansum(square)), float(np.sum(whitened**2)), len(root), variance, alpha)
    normalized = np.full(len(found.distance), np.nan)
    normalized[found.inside] = np.sqrt(square / 2.0)
    distance = found.distance[found.inside]
    return CheckSpline(
        id=curve.id,
        distance=found.distance,
        rms=float(np.sqrt(np.mean(distance**2))),
        largest=float(distance.max()),
        sigma_mean=float(np.sqrt(np.mean(np.einsum("pii->pi", blocks)))),
        mean=float(distance.mean()),
        shift=found.across.mean(axis=0),
        normalized=normalized,
        critical=float(np.sqrt(critical / 2.0)),
        beyond=int((square > critical).sum()),
        together=together,
    )


def offsets_of(cofactors: Cofactors, k: int) -> Offsets:
    """Offsets of one adjusted curve from its given points."""
    prepared, state = cofactors.assembler.prepared, cofactors.solution.state
    curve, basis = prepared.network.curves[k], prepared.curves.bases[k]
    given = curve.check_values if curve.check_values is not None else given_points(curve)
    start, stop = prepared.curves.coefficient_start[k], prepared.curves.coefficient_start[k + 1]
    own = state.coefficients[start:stop]
    u, distance = nearest_on_curve(basis, own, given)
    inside = np.ones(len(u), dtype=bool)
    if not basis.closed:
        inside = (u > basis.break_points[0]) & (u < basis.break_points[-1])
    rows = np.flatnonzero(inside)
    tangent = basis.evaluate(u[rows], own, 1)
    plane = np.linalg.svd(tangent[:, :, None], full_matrices=True)[0][:, :, 1:]
    return Offsets(
        distance=np.where(inside, distance, np.nan),
        inside=rows,
        u=u[rows],
        across=basis.evaluate(u[rows], own) - given[rows],
        plane=plane,
    )


def _dispersion(cofactors: Cofactors, k: int, found: Offsets) -> FloatArray:
    """Cofactors of all offsets together (p, 2, p, 2), or of single ones (p, 2, 2) where these are too many."""
    assembler = cofactors.assembler
    curves, layout = assembler.prepared.curves, assembler.layout
    segment, t = curves.bases[k].locate(found.u)
    segment = segment + int(curves.segment_start[k])
    weights = curves.weights(segment, t)  # (p, w)
    columns = curves.columns[segment]
    count = len(found.u)
    if too_many(cofactors, 2 * count):
        blocks = cofactors.coefficient_windows(columns).reshape(count, curves.support, 3, curves.support, 3)
        return np.asarray(
            np.einsum(
                "pj,pjakb,pk,pac,pbd->pcd", weights, blocks, weights, found.plane, found.plane, optimize=True
            )
        )
    functions = np.zeros((count, 2, int(layout.node_starts[-1])))
    place = layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)  # (p, w, 3)
    values = np.einsum("pw,pak->pkwa", weights, found.plane)
    rows, sides = np.arange(count)[:, None, None, None], np.arange(2)[None, :, None, None]
    np.add.at(functions, (rows, sides, place[:, None]), values)
    return cofactors_of(cofactors, functions.reshape(2 * count, -1)).reshape(count, 2, count, 2)


def _together(square: float, norm: float, points: int, variance: VarianceFactor, alpha: float) -> CheckTest:
    """Test of the sum of squares of `points` correlated offsets; `norm` is |R|^2."""
    effective = (2.0 * points) ** 2 / norm
    return variance.test(square * effective / (2.0 * points), alpha, effective)
