"""Elimination of the object points.

With H = sum A_x'A_x + P_prior, W_a = A_eop,a' A_x,a of every image point a,

    N_ij -= sum_{a, b of one point} W_a H^-1 W_b',   h_i -= sum W_a H^-1 h_x      (i, j the images of a, b)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class PointPairs:
    """All ordered pairs (a, b) of image points of one object point with image[a] <= image[b]."""

    a: IntArray  # (q,)
    b: IntArray  # (q,)

    @classmethod
    def of(cls, point: IntArray, image: IntArray) -> PointPairs:
        """Pairs from the columns of the image point table."""
        order = np.lexsort((image, point))
        counts = np.bincount(point[order]) if len(point) else np.zeros(0, dtype=np.int64)
        starts = np.concatenate([[0], np.cumsum(counts)])
        first, second = [], []
        for rays in np.unique(counts[counts > 0]):
            members = order[starts[:-1][counts == rays][:, None] + np.arange(rays)]
            i, j = np.meshgrid(np.arange(rays), np.arange(rays), indexing="ij")
            first.append(members[:, i.ravel()].ravel())
            second.append(members[:, j.ravel()].ravel())
        none = np.zeros(0, dtype=np.int64)
        a, b = np.concatenate([none, *first]), np.concatenate([none, *second])
        keep = image[a] <= image[b]
        return cls(a[keep], b[keep])


@dataclass(frozen=True)
class EliminatedPoints:
    """What is needed to come back to the points after the reduced system is solved."""

    inverse: FloatArray  # (n, 3, 3) H^-1
    right_side: FloatArray  # (n, 3) h_x
    coupling: FloatArray  # (n_obs, 6, 3) W


def eliminate_points(
    orientation: FloatArray, object_xyz: FloatArray, residual: FloatArray, point: IntArray, prior: FloatArray,
    prior_side: FloatArray, mask: FloatArray, damping: float,
) -> EliminatedPoints:  # fmt: skip
    """Invert the 3 x 3 blocks of all points.

    Parameters
    ----------
    orientation, object_xyz, residual : whitened equations (n_obs, 2, 6), (n_obs, 2, 3), (n_obs, 2)
    prior, prior_side : (n, 3) diagonal weights and right-hand sides -P(x - x0) of the priors
    mask : (n, 3), 0 where a coordinate is fixed
    damping : Levenberg-Marquardt factor of the diagonal

    Raises
    ------
    numpy.linalg.LinAlgError
        If a point is not determined by its rays.
    """
    count = len(prior)
    a = object_xyz * mask[point][:, None, :]
    products = np.matmul(a.transpose(0, 2, 1), a)
    blocks = np.zeros((count, 3, 3))
    sides = prior_side.copy()
    against = -np.matmul(a.transpose(0, 2, 1), residual[:, :, None])[:, :, 0]
    for i in range(3):
        sides[:, i] += np.bincount(point, against[:, i], minlength=count)
        for j in range(3):
            blocks[:, i, j] = np.bincount(point, products[:, i, j], minlength=count)
    diagonal = blocks[:, range(3), range(3)] + prior
    blocks[:, range(3), range(3)] = np.where(mask > 0.0, diagonal * (1.0 + damping), 1.0)
    coupling = np.matmul(orientation.transpose(0, 2, 1), a)
    inverse: FloatArray = np.asarray(np.linalg.inv(blocks), dtype=np.float64)
    return EliminatedPoints(inverse, sides * mask, coupling)
