"""The equations of one curve by itself: dispersion across it, and tests of shifts that many links share.

    N = J'J + K'K,   J the equations across the links, K those that hold knots along (and weakly at all)
    dispersion of X(u)       B N^-1 B',   B the values of the basis
    shift of a group         s = -h'v / q,   w = s sqrt(q),   q = h'h - (J'h)' N^-1 (J'h),   h its unit vector

with residuals in their sigma; v are those of the least squares solution.  The test is that of a shift of one chain in
:mod:`splinebba_cli.core.quality.group_tests`, for a curve alone with the orientations held.

References
----------
Baarda, W. (1968): A testing procedure for use in geodetic networks. Netherlands Geodetic Commission 2 (5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.place_fit import normal_frames
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.row_groups import split_by


@dataclass(frozen=True)
class CurveNormals:
    """Residuals and normal matrix of one curve."""

    basis: CurveBasis
    coefficients: FloatArray  # (m, 3)
    link: IntArray  # (n,) links of the draft
    location: FloatArray  # (n,)
    residual: FloatArray  # (n,) across, in sigma
    design: FloatArray  # (n, 3 m)
    factor: tuple[FloatArray, bool]  # of N

    def dispersion(self, u: FloatArray) -> FloatArray:
        """Dispersion of points of the curve, (p, 3, 3) m^2."""
        rows = _basis_rows(self.basis, u)  # (p, m)
        spread = np.kron(rows, np.eye(3))  # (3 p, 3 m)
        solved = cho_solve(self.factor, spread.T)
        blocks = spread.reshape(len(u), 3, -1)
        return np.asarray(np.einsum("pic,cpj->pij", blocks, solved.reshape(-1, len(u), 3)))

    def sigma_across(self, u: FloatArray) -> FloatArray:
        """Largest standard deviation across the curve, (p,) metres."""
        tangent = self.basis.evaluate(u, self.coefficients, 1)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
        frame = normal_frames(tangent)
        lateral = np.einsum("pia,pij,pjb->pab", frame, self.dispersion(u), frame)
        return np.asarray(np.sqrt(np.linalg.eigvalsh(lateral)[:, -1]))

    def shift(self, group: BoolArray) -> tuple[float, float]:
        """Shift of a group of links across the curve, in sigma, and its standardised value w.

        Parameters
        ----------
        group : (n,) of the links of this curve
        """
        h = group.astype(float)
        moved = self.design.T @ h
        q = float(h @ h - moved @ cho_solve(self.factor, moved))
        if q < 1e-3 * float(h.sum()):
            return 0.0, 0.0
        shift = -float(h @ self.residual) / q
        return shift, shift * np.sqrt(q)


def curve_normals(draft: Draft, curves: IntArray | None = None) -> list[CurveNormals]:
    """The equations of curves of a draft, default all."""
    rows, gauge = draft.equations(), draft.holding_rows()
    count, start = len(draft.row), draft.prepared.curves.coefficient_start
    columns = draft.prepared.curves.columns[rows.segment[:count]]
    held_of = split_by(gauge.curve, len(draft.curves))
    found = []
    for k in range(len(draft.curves)) if curves is None else curves.tolist():
        first, size = int(start[k]), int(start[k + 1] - start[k])
        own = draft.links_by_curve[k]
        design = _spread(columns[own] - first, rows.weights[own], rows.direction[own], size)
        held = held_of[k]
        hold = np.zeros((len(held), size, 3))
        np.add.at(hold, (np.arange(len(held))[:, None], gauge.columns[held] - first), gauge.jacobian[held])
        holding = hold.reshape(len(held), -1)
        normal = design.T @ design + holding.T @ holding
        normal[np.diag_indices(len(normal))] *= 1.0 + 1e-10
        found.append(
            CurveNormals(
                draft.prepared.curves.bases[k], draft.coefficients_of(k), own, draft.state.location[own],
                rows.residual[own], design, cho_factor(normal, lower=True),
            )
        )  # fmt: skip
    return found


def _spread(columns: IntArray, weights: FloatArray, direction: FloatArray, size: int) -> FloatArray:
    """Rows over all coefficients of a curve, (n, 3 size)."""
    full = np.zeros((len(columns), size, 3))
    np.add.at(full, (np.arange(len(columns))[:, None], columns), weights[:, :, None] * direction[:, None, :])
    return full.reshape(len(columns), -1)


def _basis_rows(basis: CurveBasis, u: FloatArray) -> FloatArray:
    """Values of all basis functions at locations, (p, m)."""
    segment, t = basis.locate(u)
    own = np.einsum("nk,nkw->nw", t[:, None] ** np.arange(4), basis.power[segment])
    rows = np.zeros((len(u), basis.coefficient_count))
    np.add.at(rows, (np.arange(len(u))[:, None], basis.columns[segment]), own)
    return rows
