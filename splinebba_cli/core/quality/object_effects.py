"""What changes of the unknowns do to points and, across the curve, to the ends of all segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class ObjectEffects:
    """Places at the starts, then at the ends of all segments."""

    network: Network
    segment_start: IntArray  # (nc + 1,) first segment of a curve
    columns: IntArray  # (S, w)
    weights: FloatArray  # (2, S, w)
    tangent: FloatArray  # (2, S, 3) unit

    @classmethod
    def of(cls, prepared: Prepared, state: State) -> ObjectEffects:
        """Places of all curves at a state."""
        curves = prepared.curves
        segments = np.arange(len(curves.left))
        local = state.coefficients[curves.columns]
        weights, tangents = [], []
        for t in (0.0, 1.0):
            at = np.full(len(segments), t)
            weights.append(curves.weights(segments, at))
            tangent = np.matmul(curves.weights(segments, at, 1)[:, None, :], local)[:, 0]
            norm = np.linalg.norm(tangent, axis=1)[:, None]
            tangents.append(np.divide(tangent, norm, out=np.zeros_like(tangent), where=norm > 0.0))
        return cls(
            prepared.network, curves.segment_start, curves.columns, np.stack(weights), np.stack(tangents)
        )

    def largest(self, point: FloatArray, coefficients: FloatArray) -> tuple[float, str]:
        """Largest change, metres, and of which feature: points (n, 3) or, across, curves by coefficients (C, 3)."""
        size, subject = 0.0, ""
        if len(point):
            lengths = np.linalg.norm(point, axis=1)
            worst = int(np.argmax(lengths))
            size, subject = float(lengths[worst]), f"point `{self.network.points.ids[worst]}`"
        if not len(self.columns):
            return size, subject
        local = coefficients[self.columns]
        for weights, tangent in zip(self.weights, self.tangent, strict=True):
            moved = np.matmul(weights[:, None, :], local)[:, 0]
            across = moved - np.sum(moved * tangent, axis=1)[:, None] * tangent
            lengths = np.linalg.norm(across, axis=1)
            worst = int(np.argmax(lengths))
            if not subject or lengths[worst] > size:
                curve = int(np.searchsorted(self.segment_start, worst, side="right")) - 1
                size, subject = float(lengths[worst]), f"spline `{self.network.curves[curve].id}`"
        return size, subject
