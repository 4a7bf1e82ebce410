"""Dense samples of curves in the object and in images, for searches that need no exact foot point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

ROUGH = 16  # samples of a segment from which its length is known


@dataclass(frozen=True)
class CurveSamples:
    """Places on curves."""

    curve: IntArray  # (N,)
    xyz: FloatArray  # (N, 3) metres
    tangent: FloatArray  # (N, 3) unit
    spacing: float  # largest, metres

    def __len__(self) -> int:
        return len(self.curve)

    @classmethod
    def of(cls, curves: CurveSet, coefficients: FloatArray, keep: BoolArray, spacing: float) -> CurveSamples:
        """Samples of some curves, not farther apart than a spacing.

        Parameters
        ----------
        keep : (nc,) which curves
        """
        owner = curves.owner
        segment = np.flatnonzero(keep[owner])
        t = np.linspace(0.0, 1.0, ROUGH + 1)
        u = curves.left[segment, None] + curves.length[segment, None] * t * (1.0 - 1e-12)
        rough = curves.evaluate(coefficients, np.repeat(owner[segment], ROUGH + 1), u.ravel())[0]
        length = np.linalg.norm(np.diff(rough.reshape(len(segment), ROUGH + 1, 3), axis=1), axis=2).sum(
            axis=1
        )
        count = np.maximum(np.ceil(np.nan_to_num(length) / spacing), 1).astype(np.int64)
        within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        place = (within + 0.5) / np.repeat(count, count)
        chosen = np.repeat(segment, count)
        xyz, rate = curves.evaluate(
            coefficients, owner[chosen], curves.left[chosen] + place * curves.length[chosen], (0, 1)
        )
        speed = np.linalg.norm(rate, axis=1)
        good = np.flatnonzero(np.isfinite(speed) & (speed > 0.0))
        return cls(owner[chosen[good]], xyz[good], rate[good] / speed[good, None], spacing)

    def select(self, rows: IntArray | BoolArray) -> CurveSamples:
        """Some of the samples."""
        return CurveSamples(self.curve[rows], self.xyz[rows], self.tangent[rows], self.spacing)


@dataclass(frozen=True)
class SeenSamples:
    """Samples before one image, NaN behind it."""

    xy: FloatArray  # (N, 2) mm
    direction: FloatArray  # (N, 2) unit
    orientation: FloatArray  # (N, 2, 6) d xy / d(theta, X0)
    object_xyz: FloatArray  # (N, 2, 3) d xy / dX


def seen_from(
    samples: CurveSamples, principal_distance: float, rotation: FloatArray, position: FloatArray
) -> SeenSamples:
    """Samples as an image sees them.

    Parameters
    ----------
    rotation, position : (3, 3), (3,)
    """
    count = len(samples)
    xy, jacobian = project_with_jacobian(
        np.full(count, principal_distance), np.broadcast_to(rotation, (count, 3, 3)),
        np.broadcast_to(position, (count, 3)), samples.xyz,
    )  # fmt: skip
    along = np.einsum("nij,nj->ni", jacobian.object_xyz, samples.tangent)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
    return SeenSamples(xy, along, jacobian.orientation, jacobian.object_xyz)
