"""What changes of the unknowns do to points and, across the curve, to the ends of all segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class ObjectEffects:
    """Places at the starts, then at the ends of all segments."""

    network: Network
    segment_start: IntArray  # (nc + 1,) first segment of a curve
    basis: sparse.csr_array  # (2 S, C)
    tangent: FloatArray  # (2 S, 3) unit

    @classmethod
    def of(cls, prepared: Prepared, state: State) -> ObjectEffects:
        """Places of all curves at a state."""
        curves = prepared.curves
        count = len(curves.left)
        segments, t = np.tile(np.arange(count), 2), np.repeat([0.0, 1.0], count)
        basis, slope = (_over_coefficients(curves, segments, curves.weights(segments, t, k)) for k in (0, 1))
        tangent = np.asarray(slope @ state.coefficients)
        norm = np.linalg.norm(tangent, axis=1)[:, None]
        unit = np.divide(tangent, norm, out=np.zeros_like(tangent), where=norm > 0.0)
        return cls(prepared.network, curves.segment_start, basis, unit)

    def largest(self, point: FloatArray, coefficients: FloatArray) -> tuple[float, str]:
        """Largest change, metres, and of which feature: points (n, 3) or, across, curves by coefficients (C, 3)."""
        size, subject = 0.0, ""
        if len(point):
            lengths = np.linalg.norm(point, axis=1)
            worst = int(np.argmax(lengths))
            size, subject = float(lengths[worst]), f"point `{self.network.points.ids[worst]}`"
        if not len(self.tangent):
            return size, subject
        moved = np.asarray(self.basis @ coefficients)
        across = moved - np.sum(moved * self.tangent, axis=1)[:, None] * self.tangent
        lengths = np.linalg.norm(across, axis=1)
        worst = int(np.argmax(lengths))
        if not subject or lengths[worst] > size:
            segment = worst % (len(lengths) // 2)
            curve = int(np.searchsorted(self.segment_start, segment, side="right")) - 1
            size, subject = float(lengths[worst]), f"spline `{self.network.curves[curve].id}`"
        return size, subject


def _over_coefficients(curves: CurveSet, segments: IntArray, weights: FloatArray) -> sparse.csr_array:
    """Weights (k, w) at segments (k,) as rows over all coefficients, (k, C)."""
    pointer = np.arange(len(weights) + 1) * curves.support
    entries = (weights.ravel(), curves.columns[segments].ravel(), pointer)
    return sparse.csr_array(entries, shape=(len(weights), curves.coefficient_count))
