"""Measured image points by their components, so that what is done to all of them runs over contiguous memory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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

    @cached_property
    def axis_ratio(self) -> float:
        """Longer over shorter axis of the error ellipses, the largest of all; 1 for circles.

        W has singular values a >= b with a^2 + b^2 = |W|^2 and a b = |det W|.
        """
        if self.scale is not None or not self.xy.size:
            return 1.0
        w = self.whitening
        square, product = (w * w).sum(axis=(0, 1)), 2.0 * np.abs(w[0, 0] * w[1, 1] - w[0, 1] * w[1, 0])
        root = np.sqrt(np.maximum(square * square - product * product, 0.0))
        weighted = product > 0.0
        return float(np.max((square + root)[weighted] / product[weighted], initial=1.0))

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
