"""Similarity (Helmert) transformation between two sets of points, and what it does to orientations.

    y = m R x + t,  least squares over all points of the same weight:
    sum (y - y_mean)(x - x_mean)' = U D V' (singular values),   R = U S V',   m = tr(D S) / sum |x - x_mean|^2

with S = diag(1, 1, det(U V')) (Umeyama 1991, IEEE PAMI 13; Horn 1987).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray

FEWEST = 3


@dataclass(frozen=True)
class Similarity:
    """y = scale rotation x + translation."""

    scale: float
    rotation: FloatArray  # (3, 3)
    translation: FloatArray  # (3,) m
    centre: FloatArray  # (3,) of the points that were transformed: rotation and scale are about it
    rms: float  # of the distances that are left, m
    count: int

    def apply(self, xyz: FloatArray) -> FloatArray:
        """Transformed positions, (n, 3)."""
        return np.asarray(self.scale * (xyz - self.centre) @ self.rotation.T + self.centre + self.translation)

    def turn(self, rotation: FloatArray) -> FloatArray:
        """Transformed rotations object from photo, (n, 3, 3)."""
        return np.asarray(self.rotation @ rotation)

    @property
    def angles(self) -> FloatArray:
        """Small rotation angles about X, Y, Z, rad: the rotation vector."""
        axis = np.array(
            [
                self.rotation[2, 1] - self.rotation[1, 2],
                self.rotation[0, 2] - self.rotation[2, 0],
                self.rotation[1, 0] - self.rotation[0, 1],
            ]
        )
        sine = 0.5 * np.linalg.norm(axis)
        angle = np.arctan2(sine, 0.5 * (np.trace(self.rotation) - 1.0))
        return np.asarray(0.5 * axis if sine < 1e-12 else 0.5 * axis / sine * angle)


def fit_similarity(source: FloatArray, target: FloatArray) -> Similarity | None:
    """The similarity that takes `source` to `target`, (n, 3) each; None with fewer than three points or on a line."""
    if len(source) < FEWEST:
        return None
    centre, goal = source.mean(axis=0), target.mean(axis=0)
    x, y = source - centre, target - goal
    u, singular, vt = np.linalg.svd(y.T @ x)
    if singular[1] <= 1e-9 * singular[0]:
        return None
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = (u * sign) @ vt
    scale = float(singular @ sign / np.sum(x**2))
    left = target - (scale * x @ rotation.T + goal)
    rms = float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
    return Similarity(scale, rotation, goal - centre, centre, rms, len(source))
