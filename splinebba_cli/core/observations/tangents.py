"""Tangents in the image (Lee 3.40-3.45, by the angle in place of its tangent; theory, section 5).

    theta = atan2(y', x'),   wrap(theta - measured) / sigma = v

wrapped to (-pi, pi], or to (-pi/2, pi/2] where the measured direction has no sense.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_kinematics import CurveKinematics
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class TangentRows:
    """Linearised tangents, whitened."""

    residual: FloatArray  # (q,)
    slope: FloatArray  # (q,) d/du
    orientation: FloatArray  # (q, 6)
    segment: IntArray  # (q,)
    coefficients: FloatArray  # (q, w, 3) d/dP_j


def linearize_tangents(prepared: Prepared, state: State, rows: IntArray | None = None) -> TangentRows:
    """Equations of tangents at a state.

    Parameters
    ----------
    rows : (q,) which tangents; default all

    Raises
    ------
    FloatingPointError
        If a measured curve point lies behind a camera.
    """
    tangents, observed = prepared.network.tangents, prepared.network.curve_observations
    rows = np.arange(len(tangents)) if rows is None else rows
    point = tangents.point[rows]
    segment, t = prepared.curves.locate(observed.curve[point], state.location[point])
    at = CurveKinematics.at(prepared, state, observed.image[point], segment, t)
    velocity = at.velocity()
    if not np.isfinite(velocity).all():
        raise FloatingPointError("a curve point lies behind a camera")
    square = np.maximum(np.sum(velocity**2, axis=1), 1e-300)[:, None]
    turning = np.stack([-velocity[:, 1], velocity[:, 0]], axis=1) / square
    gradient = at.gradients(turning)
    angle = np.arctan2(velocity[:, 1], velocity[:, 0])
    whitening = 1.0 / prepared.tangents.sigma[rows]
    return TangentRows(
        residual=wrapped(angle - prepared.tangents.value[rows], tangents.directed[rows]) * whitening,
        slope=at.slope(turning) * whitening,
        orientation=gradient.orientation * whitening[:, None],
        segment=segment,
        coefficients=gradient.coefficients * whitening[:, None, None],
    )


def wrapped(angle: FloatArray, directed: BoolArray) -> FloatArray:
    """Angles brought into (-pi, pi], or (-pi/2, pi/2] where they have no sense."""
    half = np.where(directed, np.pi, 0.5 * np.pi)
    return np.asarray(half - np.mod(half - angle, 2.0 * half))
