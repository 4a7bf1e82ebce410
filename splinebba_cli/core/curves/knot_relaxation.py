"""Knots as unknowns: Gauss–Newton steps for coefficients and knot parameters together.

With X the curve, r = p - X(u) the residuals and n the normal plane of the curve at the foot points,

    sum_i w_i |n_i (r_i - B_i δP - sum_j ∂X(u_i)/∂τ_j δτ_j)|² = min

Along the curve residuals count little: a location is free to move there.  A step is taken, or a part of it, when it
lowers a high norm of the distances.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, diags_array
from scipy.sparse.linalg import splu

from splinebba_cli.core.curves.basis import CurveBasis, power_row
from splinebba_cli.core.curves.knot_fit import KnotFit, basis_on, refitted
from splinebba_cli.core.curves.polyline import Polyline
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

ALONG = 0.03  # factor of residuals along the curve
NORM = 6  # power of the distances that a step must lower
SCALES = (1.0, 0.3, 0.1)  # parts of a step that are tried
DAMPING = 1e-3  # share of the diagonal of the normal matrix, for knot parameters
RIDGE = 1e-10  # the same for coefficients
FARTHEST = 0.4  # of the shorter neighbouring segment
COLOURS = 7  # knots so far apart do not touch the same segment
STEP = 1e-5  # of the shorter neighbouring segment, for the derivative


def relaxed(polyline: Polyline, fit: KnotFit, threshold: float, free: BoolArray, steps: int) -> KnotFit:
    """Move free knots so that a high norm of the distances becomes smaller; a kept threshold stays kept.

    Parameters
    ----------
    free : (k,) which knots may move; never the ends
    steps : at most so many
    """
    for _ in range(steps):
        move = _moves(polyline, fit, free)
        for scale in SCALES:
            trial = refitted(polyline, fit, fit.knots + scale * move, threshold, reweightings=0)
            if trial.largest <= max(threshold, fit.largest) and _cost(trial) < _cost(fit):
                break
        else:
            break
        gain = _cost(trial) / _cost(fit)
        fit = trial
        if gain > 0.98:
            break
    return fit


def _cost(fit: KnotFit) -> float:
    """Sum of a high power of the distances."""
    return float(np.sum(fit.distance**NORM))


def holds_points(polyline: Polyline, knots: FloatArray) -> BoolArray:
    """Whether the segments between ascending knots hold a point, (k - 1,)."""
    return np.asarray(np.diff(np.searchsorted(polyline.parameters, knots)) > 0)


def _moves(polyline: Polyline, fit: KnotFit, free: BoolArray) -> FloatArray:
    basis = basis_on(polyline, fit.knots)
    shorter = np.zeros(len(fit.knots))
    shorter[1:-1] = np.minimum(np.diff(fit.knots)[1:], np.diff(fit.knots)[:-1])
    segment, t = basis.locate(fit.location)
    values = np.einsum("nk,nkw->nw", power_row(t), basis.power[segment])
    by_knot, knot_columns = _knot_derivatives(polyline, fit, basis, shorter, free)
    tangent = basis.evaluate(fit.location, fit.coefficients, 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    residual = polyline.points - basis.evaluate(fit.location, fit.coefficients)
    weight = np.sqrt(fit.weight)

    def whitened(vectors: FloatArray) -> FloatArray:
        """Weighted, and shortened along the curve; (n, 3, c)."""
        along = np.einsum("nd,ndc->nc", tangent, vectors)
        return np.asarray(
            weight[:, None, None] * (vectors - (1.0 - ALONG) * tangent[:, :, None] * along[:, None, :])
        )

    rows = np.concatenate(
        [np.einsum("nw,de->ndwe", values, np.eye(3)).reshape(len(t), 3, -1), by_knot], axis=2
    )
    rows, right = whitened(rows), whitened(residual[:, :, None])[:, :, 0]
    coefficient = 3 * basis.columns[segment][:, :, None] + np.arange(3)
    columns = np.concatenate(
        [coefficient.reshape(len(t), -1), 3 * basis.coefficient_count + knot_columns], axis=1
    )
    step = _solution(rows, right, columns, 3 * basis.coefficient_count, len(fit.knots))
    step = np.clip(step, -FARTHEST * shorter, FARTHEST * shorter) * free
    empty = np.flatnonzero(~holds_points(polyline, fit.knots + step))
    step[empty] = step[empty + 1] = 0.0
    return step


def _knot_derivatives(
    polyline: Polyline, fit: KnotFit, basis: CurveBasis, shorter: FloatArray, free: BoolArray
) -> tuple[FloatArray, IntArray]:
    """∂X(u_i)/∂τ of the knots near u_i, (n, 3, colours), and the numbers of these knots, (n, colours)."""
    count = len(fit.knots) - 1
    colours = min(COLOURS, count + 1)
    if basis.closed:
        colours = next(c for c in range(COLOURS, count + 1) if count % c == 0) if count > COLOURS else count
    before = basis.evaluate(fit.location, fit.coefficients)
    segment, _ = basis.locate(fit.location)
    derivatives = np.zeros((len(segment), 3, colours))
    numbers = np.zeros((len(segment), colours), dtype=np.int64)
    knot = np.arange(count + 1)
    for colour in range(colours):
        shift = np.where((knot % colours == colour) & free, STEP * shorter, 0.0)
        # the knot of this colour among segment - 2 … segment + 4
        numbers[:, colour] = segment - 2 + (colour - (segment - 2)) % colours
        numbers[:, colour] = (
            numbers[:, colour] % count if basis.closed else np.clip(numbers[:, colour], 0, count)
        )
        length = shift[numbers[:, colour]]
        if not shift.any():
            continue
        after = basis_on(polyline, fit.knots + shift).evaluate(fit.location, fit.coefficients)
        known = length > 0.0
        derivatives[known, :, colour] = (after - before)[known] / length[known, None]
    return derivatives, numbers


def _solution(
    rows: FloatArray, right: FloatArray, columns: IntArray, coefficients: int, knots: int
) -> FloatArray:
    """Steps of the knots from the joint normal equations."""
    width, size = rows.shape[2], coefficients + knots
    design = coo_matrix(
        (
            rows.ravel(),
            (np.repeat(np.arange(rows.shape[0] * 3), width), np.repeat(columns, 3, axis=0).ravel()),
        ),
        shape=(rows.shape[0] * 3, size),
    ).tocsr()
    normal = (design.T @ design).tocsc()
    diagonal = normal.diagonal()
    damping = np.where(np.arange(size) < coefficients, RIDGE, DAMPING) * diagonal + 1e-14 * diagonal.max()
    factor = splu((normal + diags_array(damping)).tocsc())
    return np.asarray(factor.solve(np.asarray(design.T @ right.ravel())))[coefficients:]
