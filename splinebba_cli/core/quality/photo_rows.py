"""What a bias of measured photo coordinates does to the whitened equations, row by row.

    point       e = diag(1 / sigma_x, 1 / sigma_y) b                         two rows
    on a curve  e = n' diag(1 / sigma_x, 1 / sigma_y) b,  n the whitened unit normal of the projected curve

b the bias of the measured coordinates, mm in the measured photo frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.residual_projector import ResidualProjector


@dataclass(frozen=True)
class PhotoRows:
    """Rows of curve points and image points, in the order of the sparse design."""

    image: IntArray  # (R,)
    camera: IntArray  # (R,)
    curve: IntArray  # (R,) -1 of points
    across: BoolArray  # (R,) equations across a curve
    xy: FloatArray  # (R, 2) measured, from the principal point, mm
    sensitivity: FloatArray  # (R, 2) d whitened / d measured, 1/mm
    residual: FloatArray  # (R,) whitened, adjusted - measured
    count: int  # rows of the design

    @classmethod
    def of(cls, projector: ResidualProjector) -> PhotoRows:
        """The rows of a solution."""
        network = projector.assembler.prepared.network
        on_curves, points = network.curve_observations, network.point_observations
        curve = projector.design.curve
        n = len(on_curves)
        tangent = np.stack([curve.normal[curve.along, 1], -curve.normal[curve.along, 0]], axis=1)
        direction = np.concatenate([curve.normal, tangent]) / on_curves.sigma[curve.point]
        both = np.eye(2)[None] / points.sigma[:, None, :]
        image = np.concatenate([on_curves.image[curve.point], points.image.repeat(2)])
        camera = network.images.camera[image]
        centre = np.array([each.principal_point_mm for each in network.cameras])[camera]
        rows = len(curve.point) + 2 * len(points)
        return cls(
            image=image,
            camera=camera,
            curve=np.concatenate([on_curves.curve[curve.point], np.full(2 * len(points), -1)]),
            across=np.arange(rows) < n,
            xy=np.concatenate([on_curves.photo_xy[curve.point], points.photo_xy.repeat(2, axis=0)]) - centre,
            sensitivity=np.concatenate([direction, both.reshape(-1, 2)]),
            residual=projector.design.residual[:rows],
            count=projector.design.ranges.count,
        )

    def directions(self, rows: IntArray, bias: FloatArray) -> sparse.csc_array:
        """Directions (count, p) of biases (k, p, 2), mm per unit, of the measurements of some rows (k,)."""
        values = np.sum(bias * self.sensitivity[rows][:, None, :], axis=2)
        pointer = len(rows) * np.arange(bias.shape[1] + 1, dtype=np.int32)
        entries = (
            np.ascontiguousarray(values.T).ravel(),
            np.tile(rows.astype(np.int32), bias.shape[1]),
            pointer,
        )
        return sparse.csc_array(entries, shape=(self.count, bias.shape[1]))
