"""Directions of curves that bend sharply: a point may lie a little along the curve from its foot point.

The foot point of a measured point is off along the curve by the noise of the point.  Where the curve bends by more
within that stretch than a direction tells, every direction that the curve has there may be the one measured.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.matching.candidates.search import Candidates
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

LOOKED_AT = 0.1  # rad: smaller turns need no excuse
REACH = 3.0  # sigma of the point, along the curve
MOST = 0.25  # of a curve: where it is seen end on, no stretch of it is long in the image
PLACES = (-1.0, -0.5, 0.0, 0.5, 1.0)  # of the reach


def turns(angle: FloatArray, tangent: FloatArray) -> FloatArray:
    """Angles from directions (k,) to tangents (k, 2), both up to half a turn; -pi/2 to pi/2, NaN unknown."""
    cosine, sine = np.cos(angle), np.sin(angle)
    across = cosine * tangent[:, 1] - sine * tangent[:, 0]
    along = cosine * tangent[:, 0] + sine * tangent[:, 1]
    return np.asarray(np.arctan2(np.where(along < 0.0, -across, across), np.abs(along)))


def turns_within_noise(
    scene: Scene, candidates: Candidates, angle: FloatArray, wanted: BoolArray
) -> FloatArray:
    """Angles from measured directions to the nearest one that the projected curve has near the foot point.

    Parameters
    ----------
    angle : (k,) rad, measured at the points of the candidates; NaN unknown
    wanted : (k,) candidates whose turn is excused that way, the others get that at the foot point

    Returns
    -------
    (k,) rad, -pi/2 to pi/2; NaN unknown
    """
    turn = turns(angle, candidates.tangent)
    rows = np.flatnonzero(wanted & (np.abs(turn) > LOOKED_AT))
    if not len(rows):
        return turn
    found = [turns(angle[rows], _tangents(scene, candidates, rows, share)) for share in PLACES]
    least = turn[rows]
    for before, after in pairwise(found):
        passed = (np.sign(before) != np.sign(after)) & (np.abs(before - after) < 0.5 * np.pi)
        for one in (before, after):
            least = np.where(np.abs(one) < np.abs(least), one, least)
        least = np.where(passed, 0.0, least)
    turn[rows] = least
    return turn


def _tangents(scene: Scene, candidates: Candidates, rows: IntArray, share: float) -> FloatArray:
    """Directions (q, 2) of projected curves at a share of the reach from foot points."""
    curves, curve, image = scene.curves, candidates.curve[rows], scene.image[candidates.point[rows]]
    with np.errstate(divide="ignore", invalid="ignore"):
        step = share * REACH * scene.noise[candidates.point[rows]] / candidates.speed[rows]
    most = MOST * (curves.last - curves.first)[curve]
    step = np.clip(np.nan_to_num(step), -most, most)
    u = candidates.location[rows] + step
    inside = np.clip(u, curves.first[curve], curves.last[curve])
    segment, t = curves.locate(curve, np.where(curves.closed[curve], u, inside))
    xyz, rate, _ = curves.derivatives(scene.polynomials, segment, t)
    _, jacobian = project_with_jacobian(
        scene.principal_distance[image], scene.rotation[image], scene.position[image], xyz
    )
    return np.asarray(np.matmul(jacobian.object_xyz, rate[:, :, None])[:, :, 0])
