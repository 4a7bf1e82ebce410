"""Measured image points by their components, so that what is done to all of them runs over contiguous memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class MeasuredRays:
    """Measured points by their components, the last axis running over points."""

    xy: FloatArray  # (2, n) mm, corrected
    whitening: FloatArray  # (2, 2, n) W
    scale: float | None  # W is this number times the unit matrix for all points, None where it is not

    @classmethod
    def of(cls, xy: FloatArray, whitening: FloatArray) -> MeasuredRays:
        """From rows (n, 2) and (n, 2, 2)."""
        first = float(whitening[0, 0, 0]) if len(whitening) else 1.0
        scale = (
            first if np.array_equal(whitening, np.broadcast_to(first * np.eye(2), whitening.shape)) else None
        )
        return cls(np.ascontiguousarray(xy.T), np.ascontiguousarray(whitening.transpose(1, 2, 0)), scale)

    def __getitem__(self, points: slice | IntArray | BoolArray) -> MeasuredRays:
        """Some of the points."""
        whitening = self.whitening[:, :, points] if self.scale is None else self.whitening[:, :, :0]
        return MeasuredRays(self.xy[:, points], whitening, self.scale)

    def whitened(self, xy: FloatArray) -> FloatArray:
        """W times vectors (2, n)."""
        if self.scale is not None:
            return np.asarray(self.scale * xy)
        out: FloatArray = self.whitening[:, 0] * xy[0]
        out += self.whitening[:, 1] * xy[1]
        return out

    def transposed(self, direction: FloatArray) -> FloatArray:
        """W' times vectors (2, n)."""
        if self.scale is not None:
            return np.asarray(self.scale * direction)
        out: FloatArray = direction[0] * self.whitening[0]
        out += direction[1] * self.whitening[1]
        return out
