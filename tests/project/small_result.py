"""A result of the example project, good enough for what only reads a few of its numbers."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.evidence import Reliability
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import (
    AdjustmentResult,
    Checks,
    CurveResult,
    ImageResult,
    PointResult,
    ResidualTable,
    SegmentCoefficients,
    Statistics,
)


def result_of(network: Network) -> AdjustmentResult:
    """A result whose values differ a little from the approximate ones; only what is needed here."""
    count = len(network.images.ids)
    eop = np.zeros((count, 6))
    eop[:, :3] = [[0.01, 0.02, 0.03]] * count
    eop[:, 3:] = network.images.position + network.origin + 0.5
    curves = []
    for curve in network.curves:
        values = curve.values + network.origin + 0.25
        size = len(values)
        parameters = np.linspace(0.0, 1.0, size)
        interval = np.column_stack([parameters[:-1], parameters[1:]])
        segments = SegmentCoefficients(interval, np.zeros((size - 1, 4, 3)), np.zeros((size - 1, 4, 3)))
        zero, none = np.zeros((size, 3)), np.zeros(0)
        one = CurveResult(
            values, np.zeros((size, 3, 3)), values, parameters, zero, curve.values + network.origin, segments,
            none, zero[:0], zero[:0, :2], zero[:0], 0.0, 0.0, 0.0, 1, 1, none,
        )  # fmt: skip
        curves.append(one)
    xyz = np.nan_to_num(network.points.xyz) + network.origin + 0.125
    nothing = np.zeros((0, 2))
    empty = ResidualTable(*[nothing] * 7, Reliability(nothing, nothing, nothing))
    return AdjustmentResult(
        network, True, "step negligible", (), Statistics(0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, None),
        ImageResult(eop, rotation_object_from_photo(eop[:, :3]), np.zeros((count, 6, 6)), eop > -9e9),
        tuple(curves), PointResult(xyz, np.zeros((len(xyz), 3, 3)), np.zeros(len(xyz), dtype=np.int64)),
        empty, empty, (), Checks(), (),
    )  # fmt: skip
