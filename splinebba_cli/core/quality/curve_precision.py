"""Precision of adjusted curves: across them (datum-independent) and along them (datum-dependent).

For a curve point, C_X = sum_jl N_j N_l C_jl (3 x 3); projected on the normal plane of X'(u) its two eigenvalues are
the semi-axes squared of the lateral standard ellipse.  (theory, section 6)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.row_groups import RowGroups

SAMPLES = np.linspace(0.0, 1.0, 5)[:-1]


@dataclass(frozen=True)
class CurveSamples:
    """Places along all curves with their precision."""

    curve: IntArray  # (p,)
    segment: IntArray  # (p,)
    u: FloatArray  # (p,)
    xyz: FloatArray  # (p, 3) local
    tangent: FloatArray  # (p, 3) unit
    dispersion: FloatArray  # (p, 3, 3)
    across: FloatArray  # (p, 2) semi-axes, larger first, m
    direction: FloatArray  # (p, 3) of the larger semi-axis
    along: FloatArray  # (p,) sigma along the curve, m
    at_knot: BoolArray  # (p,)


def sample_places(curves: CurveSet) -> tuple[IntArray, IntArray, FloatArray]:
    """Curve, segment and t of the samples: the knots, three places between, and the end of open curves."""
    segments = np.arange(len(curves.left))
    curve_of = np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start))
    segment = np.repeat(segments, len(SAMPLES))
    t = np.tile(SAMPLES, len(segments))
    ends = curves.segment_start[1:][~curves.closed] - 1
    segment, t = np.concatenate([segment, ends]), np.concatenate([t, np.ones(len(ends))])
    order = np.lexsort((t, segment))
    return curve_of[segment[order]], segment[order], t[order]


def curve_samples(cofactors: Cofactors, scale: float) -> CurveSamples:
    """Samples of all curves; dispersions multiplied by `scale` (the variance of unit weight)."""
    curves = cofactors.assembler.prepared.curves
    coefficients = cofactors.solution.state.coefficients
    curve, segment, t = sample_places(curves)
    if not len(segment):
        none, plane = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        return CurveSamples(
            none, none, np.zeros(0), plane, plane, np.zeros((0, 3, 3)), np.zeros((0, 2)), plane, np.zeros(0),
            np.zeros(0, dtype=bool),
        )  # fmt: skip
    local = coefficients[curves.columns[segment]]
    weights = curves.weights(segment, t)
    xyz = np.einsum("pw,pwd->pd", weights, local)
    tangent = np.einsum("pw,pwd->pd", curves.weights(segment, t, 1), local)
    norm = np.linalg.norm(tangent, axis=1)
    tangent = np.where(
        norm[:, None] > 0.0, tangent / np.where(norm > 0.0, norm, 1.0)[:, None], [0.0, 0.0, 1.0]
    )
    dispersion = window_dispersion(cofactors, curves, segment, weights) * scale
    lateral = np.eye(3) - tangent[:, :, None] * tangent[:, None, :]
    values, vectors = np.linalg.eigh(lateral @ dispersion @ lateral)
    values = np.sqrt(np.maximum(values, 0.0))
    along = np.einsum("pi,pij,pj->p", tangent, dispersion, tangent)
    return CurveSamples(
        curve, segment, curves.left[segment] + t * curves.length[segment], xyz, tangent, dispersion,
        values[:, [2, 1]], vectors[:, :, 2], np.sqrt(np.maximum(along, 0.0)), (t == 0.0) | (t == 1.0),
    )  # fmt: skip


def window_dispersion(
    cofactors: Cofactors, curves: CurveSet, segment: IntArray, weights: FloatArray
) -> FloatArray:
    """Cofactors of sum_j N_j P_j at places of segments, (p, 3, 3)."""
    distinct, inverse = np.unique(segment, return_inverse=True)
    every = len(distinct) == len(curves.left)
    windows = cofactors.coefficient_windows(curves.columns if every else curves.columns[distinct])
    support = curves.support
    blocks = windows.reshape(len(distinct), support, 9 * support)
    padded = np.concatenate([weights, np.zeros((1, support))])
    out = np.empty((len(padded), 3, 3))
    for chosen, members in RowGroups.of(inverse).batches(9 * support):
        own = padded[members]
        half = np.matmul(own, blocks[chosen]).reshape(*own.shape[:2], 3, support, 3)
        out[members] = np.sum(half * own[:, :, None, :, None], axis=3)
    return out[:-1]


def segment_coefficients(cofactors: Cofactors, scale: float) -> tuple[FloatArray, FloatArray]:
    """Lee's a, b, c of all segments for t in [0, 1] and their sigma, (S, 4, 3) each; 0 of trigonometric ones."""
    curves = cofactors.assembler.prepared.curves
    values, sigma = np.zeros((len(curves.left), MAX_POWER, 3)), np.zeros((len(curves.left), MAX_POWER, 3))
    own = np.flatnonzero(~curves.trigonometric)
    if not len(own):
        return values, sigma
    power, columns = curves.power[own, :MAX_POWER], curves.columns[own]
    values[own] = np.matmul(power, cofactors.solution.state.coefficients[columns])
    every = len(own) == len(curves.left)
    blocks = cofactors.coefficient_windows(curves.columns if every else columns)
    for axis in range(3):
        half = np.matmul(power, blocks[:, axis::3, axis::3])
        variance = np.sum(half * power, axis=2)
        sigma[own, :, axis] = np.sqrt(np.maximum(variance * scale, 0.0))
    return values, sigma
