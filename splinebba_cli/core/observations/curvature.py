"""Second derivatives of the sum of squares at points whose locations follow the curve.

A step along a direction that the measurements hardly see (a curve that slides along itself) leaves the true valley of
v'Pv at second order, with residuals that then outweigh what the step was to gain: Gauss-Newton steps crawl.  With whitened
residual r of a measured point, its derivatives J over the parameters p and b over u, exact are

    H_pu = J'b + C',  C = r . db/dp        H_uu = b . b + r . r''

(C: the direction of the curve turns with its coefficients and with the image), and eliminating u leaves

    J'J - (J'b + C') (b . b + r . r'')^-1 (b'J + C).

What this differs from J_n'J_n, the equation across the curve, is returned; for chains likewise with the tridiagonal
T = B'B + diag(r . r'').  Second derivatives over the parameters alone (of the projection) and of arc lengths are left
out: they are smaller by the ratio of residuals to the principal distance, and of the bend to the length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.observations.curve_kinematics import CurveKinematics
from splinebba_cli.core.observations.linked_points import LinkedBatch
from splinebba_cli.core.state import Prepared, State

LEAST = 0.1  # of b . b that H_uu keeps, so that the location stays a minimum


@dataclass(frozen=True)
class Turning:
    """What makes a location turn with the parameters: C, and r . r''."""

    rows: FloatArray  # (k, 6 + 3 w) C over (theta, X0) and the coefficients under the segment
    bend: FloatArray  # (k,) r . r''
    segment: IntArray  # (k,)


def turning_of(prepared: Prepared, state: State, point: IntArray) -> Turning:
    """C and r . r'' of measured points (k,)."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    image = observed.image[point]
    segment, t = curves.locate(observed.curve[point], state.location[point])
    at = CurveKinematics.at(prepared, state, image, segment, t)
    whitening, velocity = prepared.curve_rays.whitening[point], at.velocity()
    xy = -at.principal_distance[:, None] * at.q[:, :2] / at.q[:, 2:]
    r = np.matmul(whitening, (xy - prepared.curve_rays.xy[point])[:, :, None])[:, :, 0]
    pull = np.matmul(r[:, None, :], whitening)[:, 0]  # r'W: r . W p' is a function of the velocity p'
    gradient = at.gradients(pull)
    return Turning(
        np.concatenate([gradient.orientation, _flat(gradient.coefficients)], axis=1),
        np.where(np.isfinite(velocity[:, 0]), at.slope(pull), 0.0),
        segment,
    )


@dataclass(frozen=True)
class PointCurvature:
    """Corrections of single points, to be added to the normal matrix."""

    image: IntArray  # (k,)
    segment: IntArray  # (k,)
    matrix: FloatArray  # (k, 6 + 3 w, 6 + 3 w)


def point_curvature(prepared: Prepared, state: State, held: IntArray) -> PointCurvature:
    """Corrections of all points with a free location of their own."""
    single = ~prepared.chains.linked & prepared.curves.has_location[prepared.network.curve_observations.curve]
    single[held] = False
    point = np.flatnonzero(single)
    along, turning = along_rows(prepared, state, point), turning_of(prepared, state, point)
    row = np.concatenate([along.orientation, _flat(along.coefficients)], axis=1)
    square = along.slope**2
    inverse = 1.0 / np.maximum(square + turning.bend, LEAST * np.maximum(square, 1e-300))
    mixed = along.slope[:, None] * row + turning.rows
    matrix = row[:, :, None] * row[:, None, :] - inverse[:, None, None] * mixed[:, :, None] * mixed[:, None, :]
    return PointCurvature(prepared.network.curve_observations.image[point], along.segment, matrix)


def chain_curvature(prepared: Prepared, state: State, batch: LinkedBatch) -> FloatArray:
    """Corrections of the chains of a batch over (theta, X0) and the coefficients under each, (G, P, P)."""
    chains, rows = batch.chains, batch.rows
    used = chains.points >= 0
    turning = turning_of(prepared, state, chains.points[used])
    g, _ = np.nonzero(used)
    size = batch.columns.shape[1]
    spread = np.zeros((len(g), 6 + 3 * size))
    spread[:, :6] = turning.rows[:, :6]
    width = prepared.curves.support
    columns = prepared.curves.columns[turning.segment]
    place = np.argmax(batch.columns[g][:, :, None] == columns[:, None, :], axis=1)  # (k, w)
    target = 6 + 3 * place[:, :, None] + np.arange(3)
    values = turning.rows[:, 6:].reshape(len(g), width, 3)
    np.add.at(spread, (np.arange(len(g))[:, None, None], target), values)
    mixed = np.zeros((*used.shape, 6 + 3 * size))
    mixed[used] = spread
    bend = np.zeros(used.shape)
    bend[used] = turning.bend
    j = np.concatenate([rows.along, rows.tangent, rows.arc], axis=1)[:, :, :-1]
    b = _locations(rows.along_slope, rows.tangent_slope, rows.arc_slopes)
    free = rows.along_slope > 0.0
    mixed *= free[:, :, None]
    square = np.einsum("gri,grj->gij", b, b)
    eye = np.arange(square.shape[1])
    own = square[:, eye, eye]
    square[:, eye, eye] = np.where(free, np.maximum(own + bend, LEAST * own), 1.0)
    across = np.einsum("gri,grp->gip", b, j) + mixed
    kept = batch.eliminated.kept[:, :, :-1]
    whole = np.matmul(j.transpose(0, 2, 1), j) - np.matmul(across.transpose(0, 2, 1), np.linalg.solve(square, across))
    return np.asarray(whole - np.matmul(kept.transpose(0, 2, 1), kept))


def _locations(along: FloatArray, tangent: FloatArray, arc: FloatArray) -> FloatArray:
    """Dense rows over the locations of every chain, in the order along, tangent, arc, (G, 3 L - 1, L)."""
    chains, length = along.shape
    out = np.zeros((chains, 3 * length - 1, length))
    i = np.arange(length)
    out[:, i, i], out[:, length + i, i] = along, tangent
    j = i[:-1]
    out[:, 2 * length + j, j], out[:, 2 * length + j, j + 1] = arc[:, :, 0], arc[:, :, 1]
    return out


def _flat(coefficients: FloatArray) -> FloatArray:
    """Derivatives (k, w, 3) as rows (k, 3 w)."""
    return coefficients.reshape(len(coefficients), 3 * coefficients.shape[1])
