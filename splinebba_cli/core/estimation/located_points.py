"""Measured curve points at a state: their segments, and the residuals that assembly leaves behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class ResidualsOnCurves:
    """What is kept of every measured point, (n,) each, whitened."""

    across: FloatArray
    along: FloatArray
    kept: BoolArray  # whether the equation along the curve stays: location held, or no foot point

    @classmethod
    def none(cls, count: int) -> ResidualsOnCurves:
        """Room for `count` points."""
        return cls(np.zeros(count), np.zeros(count), np.zeros(count, dtype=bool))

    @property
    def squares(self) -> FloatArray:
        """Sum of squares that every point leaves, (n,)."""
        return np.asarray(self.across**2 + np.where(self.kept, self.along, 0.0) ** 2)


@dataclass(frozen=True)
class Located:
    """A state with the segments of measured points, found when they are asked for."""

    prepared: Prepared
    state: State
    polynomials: FloatArray  # (S, 4, 3) of the object frame

    @classmethod
    def of(cls, prepared: Prepared, state: State) -> Located:
        """At the present locations."""
        return cls(prepared, state, prepared.curves.segment_polynomials(state.coefficients)[:, :4])

    def segments(self, points: IntArray) -> tuple[IntArray, FloatArray]:
        """Segments of some measured points and t on them, (k,) each."""
        curve = self.prepared.network.curve_observations.curve
        return self.prepared.curves.locate(curve[points], self.state.location[points])
