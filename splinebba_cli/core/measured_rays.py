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

    @classmethod
    def of(cls, xy: FloatArray, whitening: FloatArray) -> MeasuredRays:
        """From rows (n, 2) and (n, 2, 2)."""
        return cls(np.ascontiguousarray(xy.T), np.ascontiguousarray(whitening.transpose(1, 2, 0)))

    def __getitem__(self, points: slice | IntArray | BoolArray) -> MeasuredRays:
        """Some of the points."""
        return MeasuredRays(self.xy[:, points], self.whitening[:, :, points])

    def whitened(self, xy: FloatArray) -> FloatArray:
        """W times vectors (2, n)."""
        out: FloatArray = self.whitening[:, 0] * xy[0]
        out += self.whitening[:, 1] * xy[1]
        return out
