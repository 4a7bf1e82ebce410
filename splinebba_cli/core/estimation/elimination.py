"""Elimination of the object points; fixed ones are no unknowns and cost nothing.

With H = sum A_x'A_x + P_prior, W_a = A_eop,a' A_x,a of every image point a,

    N_ij -= sum_{a, b of one point} W_a H^-1 W_b',   h_i -= sum W_a H^-1 h_x      (i, j the images of a, b)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.image_points import PointRows


@dataclass(frozen=True)
class PointPairs:
    """All ordered pairs (a, b) of image points of one eliminated point with image[a] <= image[b]."""

    a: IntArray  # (q,)
    b: IntArray  # (q,)

    @classmethod
    def of(cls, point: IntArray, image: IntArray, mask: FloatArray) -> PointPairs:
        """Pairs from the columns of the image point table.

        Parameters
        ----------
        mask : (n, 3), 0 where a coordinate is not eliminated
        """
        rows = rows_of_eliminated(point, mask)
        order = rows[np.lexsort((image[rows], point[rows]))]
        counts = np.bincount(point[order]) if len(order) else np.zeros(0, dtype=np.int64)
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
    rows: PointRows, image: IntArray, point: IntArray, image_mask: FloatArray, mask: FloatArray,
    prior: FloatArray, prior_side: FloatArray, damping: float,
) -> EliminatedPoints:  # fmt: skip
    """Invert the 3 x 3 blocks of all points.

    Parameters
    ----------
    rows : whitened equations of image points
    image, point : (n_obs,) of these
    image_mask, mask : (m, 6), (n, 3), 0 where an unknown is fixed or not eliminated
    prior, prior_side : (n, 3) diagonal weights and right-hand sides -P(x - x0) of the priors
    damping : Levenberg-Marquardt factor of the diagonal

    Raises
    ------
    numpy.linalg.LinAlgError
        If a point is not determined by its rays.
    """
    count = len(prior)
    seen = rows_of_eliminated(point, mask)
    coupling = np.zeros((len(point), image_mask.shape[1], 3))
    inverse = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
    sides = prior_side * mask
    free = np.flatnonzero(mask.any(axis=1))
    number = np.zeros(count, dtype=np.int64)
    number[free] = np.arange(len(free))
    own, mask = number[point[seen]], mask[free]
    a = rows.object_xyz[seen] * mask[own][:, None, :]
    products = np.matmul(a.transpose(0, 2, 1), a)
    against = -np.matmul(a.transpose(0, 2, 1), rows.residual[seen][:, :, None])[:, :, 0]
    blocks = np.zeros((len(free), 3, 3))
    for i in range(3):
        sides[free, i] += np.bincount(own, against[:, i], minlength=len(free))
        for j in range(3):
            blocks[:, i, j] = np.bincount(own, products[:, i, j], minlength=len(free))
    diagonal = blocks[:, range(3), range(3)] + prior[free]
    blocks[:, range(3), range(3)] = np.where(mask > 0.0, diagonal * (1.0 + damping), 1.0)
    orientation = rows.orientation[seen] * image_mask[image[seen]][:, None, :]
    coupling[seen] = np.matmul(orientation.transpose(0, 2, 1), a)
    inverse[free] = np.linalg.inv(blocks)
    return EliminatedPoints(inverse, sides, coupling)


def rows_of_eliminated(point: IntArray, mask: FloatArray) -> IntArray:
    """Image points (of the object points `point`) whose object point has an eliminated coordinate."""
    return np.flatnonzero(np.asarray(mask.any(axis=1))[point])
