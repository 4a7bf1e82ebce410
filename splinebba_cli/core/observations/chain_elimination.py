"""Elimination of the locations of a chain by Givens rotations, all chains of a batch at once.

The whitened rows of a chain of points i = 1..L are, with their entries on the locations u,

    along the curve at i:   s_i on u_i          tangent at i:  c_i on u_i
    arc from i to i + 1:    d_i on u_i, e_i on u_{i+1}

and J over the parameters (residual in the last column).  Rotations from the first to the last point leave

    a bidiagonal triangle   D_i u_i + E_i u_{i+1} + G_i p     (the equations that give the locations back)
    and rows K p            free of locations: what the chain says about the parameters.

B'B = T of the locations is tridiagonal with Cholesky factor (D, E); every rotation is orthogonal, so that nothing is
lost by cancellation, and the work is proportional to the length of the chain.  (theory, section 3)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray


@dataclass(frozen=True)
class ChainRows:
    """Whitened rows of G chains of L points; P parameters, the residual last."""

    along: FloatArray  # (G, L, P + 1)
    along_slope: FloatArray  # (G, L) s; 0 where the location is held or there is no point
    tangent: FloatArray  # (G, L, P + 1) zero where there is none
    tangent_slope: FloatArray  # (G, L)
    arc: FloatArray  # (G, L - 1, P + 1) zero where there is none
    arc_slopes: FloatArray  # (G, L - 1, 2) d, e


@dataclass(frozen=True)
class EliminatedChains:
    """Triangle of the locations and rows without them."""

    kept: FloatArray  # (G, R, P + 1) rows over the parameters; zero rows where nothing is left
    diagonal: FloatArray  # (G, L) D, 0 where the location is no unknown
    beside: FloatArray  # (G, L - 1) E
    pivot: FloatArray  # (G, L, P + 1)

    def steps(self) -> FloatArray:
        """Change of the locations with the parameters held, (G, L)."""
        return -self.solve(self.pivot[:, :, -1:])[:, :, 0]

    def solve(self, right: FloatArray) -> FloatArray:
        """Solve the triangle from the last location to the first; right (G, L, q)."""
        out = np.zeros_like(right)
        inverse = _inverse(self.diagonal)
        for i in range(right.shape[1] - 1, -1, -1):
            value = right[:, i]
            if i < right.shape[1] - 1:
                value = value - self.beside[:, i, None] * out[:, i + 1]
            out[:, i] = inverse[:, i, None] * value
        return out

    def location_cofactors(self) -> tuple[FloatArray, FloatArray]:
        """Diagonal (G, L) and first off-diagonal (G, L - 1) of T^-1, parameters held."""
        inverse = _inverse(self.diagonal)
        own, next_to = np.zeros_like(self.diagonal), np.zeros_like(self.beside)
        last = own.shape[1] - 1
        own[:, last] = inverse[:, last] ** 2
        for i in range(last - 1, -1, -1):
            gain = inverse[:, i] * self.beside[:, i]
            next_to[:, i] = -gain * own[:, i + 1]
            own[:, i] = inverse[:, i] ** 2 + gain**2 * own[:, i + 1]
        return own, next_to


def _inverse(diagonal: FloatArray) -> FloatArray:
    return np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal != 0.0)


def eliminate_chains(rows: ChainRows) -> EliminatedChains:
    """Eliminate the locations of all chains."""
    chains, length, width = rows.along.shape
    kept = np.zeros((chains, 4 * length, width))
    diagonal, beside = np.zeros((chains, length)), np.zeros((chains, max(length - 1, 0)))
    pivot = np.zeros((chains, length, width))
    carry, carry_slope = np.zeros((chains, width)), np.zeros(chains)
    for i in range(length):
        row, slope, kept[:, 4 * i] = _rotate(carry, carry_slope, rows.along[:, i], rows.along_slope[:, i])
        row, slope, kept[:, 4 * i + 1] = _rotate(row, slope, rows.tangent[:, i], rows.tangent_slope[:, i])
        if i < length - 1:
            d, e = rows.arc_slopes[:, i, 0], rows.arc_slopes[:, i, 1]
            cosine, sine, slope = _rotation(slope, d)
            carry = cosine[:, None] * rows.arc[:, i] - sine[:, None] * row
            row = cosine[:, None] * row + sine[:, None] * rows.arc[:, i]
            carry_slope, beside[:, i] = cosine * e, sine * e
        free = slope != 0.0
        kept[~free, 4 * i + 2] = row[~free]
        pivot[free, i], diagonal[:, i] = row[free], slope
    return EliminatedChains(_without_zero_rows(kept), diagonal, beside, pivot)


def _rotation(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cosine and sine that turn (a, b) into (length, 0); no rotation where both are 0."""
    length = np.hypot(a, b)
    safe = np.where(length > 0.0, length, 1.0)
    return np.where(length > 0.0, a / safe, 1.0), b / safe, length


def _rotate(
    first: FloatArray, first_slope: FloatArray, second: FloatArray, second_slope: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotate two rows with entries on one location: the row that keeps it, its entry, and the row without."""
    cosine, sine, slope = _rotation(first_slope, second_slope)
    return (
        cosine[:, None] * first + sine[:, None] * second,
        slope,
        cosine[:, None] * second - sine[:, None] * first,
    )


def _without_zero_rows(kept: FloatArray) -> FloatArray:
    """Rows that are used in at least one chain."""
    return kept[:, (kept != 0.0).any(axis=(0, 2))]
