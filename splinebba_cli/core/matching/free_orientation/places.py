"""Known curves as a search for orientations needs them: samples along them, and distinguished places with tangents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, initial_coefficients

ROUGH = 16  # samples of a segment from which its length is known
ASIDE = 1e-6  # of a segment: how far beside a corner its two tangents are taken


@dataclass(frozen=True)
class Places:
    """Places on curves with their tangents."""

    xyz: FloatArray  # (k, 3) metres
    tangent: FloatArray  # (k, 3) unit; into the curve at an end
    curve: IntArray  # (k,)

    def __len__(self) -> int:
        return len(self.curve)


@dataclass(frozen=True)
class CurveSamples:
    """Places at equal distances along all known curves."""

    xyz: FloatArray  # (m, 3)
    tangent: FloatArray  # (m, 3) unit, ascending u
    curve: IntArray  # (m,)
    location: FloatArray  # (m,) u
    length: FloatArray  # (m,) metres of curve that a sample stands for


class KnownCurves:
    """The curves of a network whose shape is given."""

    def __init__(self, prepared: Prepared) -> None:
        self._curves = prepared.curves
        self._coefficients = initial_coefficients(prepared)
        self.used = np.flatnonzero(shape_is_given(prepared.network) & prepared.curves.has_location)
        owner = self._curves.owner
        self._segment = np.flatnonzero(np.isin(owner, self.used))
        self._owner = owner[self._segment]
        self._length = self._lengths()

    @property
    def total_length(self) -> float:
        """Metres."""
        return float(self._length.sum())

    def samples(self, count: int, shift: float = 0.5) -> CurveSamples:
        """Places at equal distances, the curves one behind the other; `shift` of a distance before the first one."""
        until = np.cumsum(self._length)
        station = (np.arange(count) + shift) * self.total_length / count
        row = np.minimum(np.searchsorted(until, station, side="right"), len(until) - 1)
        t = np.clip(1.0 - (until[row] - station) / self._length[row], 0.0, 1.0)
        segment = self._segment[row]
        u = self._curves.left[segment] + t * self._curves.length[segment]
        xyz, tangent = self._evaluate(self._owner[row], u)
        length = np.full(count, self.total_length / count)
        return CurveSamples(xyz, tangent, self._owner[row], u, length)

    def ends(self, network: Network) -> Places:
        """Ends of open curves, and corners once for either side; tangents into the curve."""
        curves = self._curves
        parts: list[tuple[int, float, float]] = []
        for k in self.used.tolist():
            if not curves.closed[k]:
                parts += [(k, float(curves.first[k]), 1.0), (k, float(curves.last[k]), -1.0)]
            knots = curves.bases[k].break_points
            for knot in network.curves[k].breaks:
                aside = ASIDE * float(np.diff(knots).min())
                parts += [(k, float(knots[knot]) + aside, 1.0), (k, float(knots[knot]) - aside, -1.0)]
        curve = np.array([part[0] for part in parts], dtype=np.int64)
        xyz, tangent = self._evaluate(curve, np.array([part[1] for part in parts]))
        return Places(xyz, tangent * np.array([part[2] for part in parts])[:, None], curve)

    def _evaluate(self, curve: IntArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not len(curve):
            return np.zeros((0, 3)), np.zeros((0, 3))
        xyz, rate = self._curves.evaluate(self._coefficients, curve, u, (0, 1))
        with np.errstate(invalid="ignore", divide="ignore"):
            return xyz, rate / np.linalg.norm(rate, axis=1, keepdims=True)

    def _lengths(self) -> FloatArray:
        """Of the segments, metres."""
        if not len(self._segment):
            return np.zeros(0)
        t = np.linspace(0.0, 1.0 - 1e-12, ROUGH + 1)
        u = self._curves.left[self._segment, None] + self._curves.length[self._segment, None] * t
        xyz = self._evaluate(np.repeat(self._owner, ROUGH + 1), u.ravel())[0].reshape(-1, ROUGH + 1, 3)
        return np.asarray(np.linalg.norm(np.diff(xyz, axis=1), axis=2).sum(axis=1))


def shape_is_given(network: Network) -> BoolArray:
    """Whether every value of a curve is fixed or has a standard deviation, (nc,)."""
    return np.array(
        [
            bool(np.isfinite(curve.sigma).all() and np.isfinite(curve.values).all() and curve.role != "check")
            for curve in network.curves
        ],
        dtype=bool,
    )
