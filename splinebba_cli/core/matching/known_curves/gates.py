"""How far a projected curve may lie from a measured point of its own: the innovation and its variance.

For a candidate with the unit normal n of the projected curve, J = d xy / d(theta, X0) and A = d xy / dX

    d = n'(x_curve - x_point),    var d = n'(J S_eop J' + A S_curve A' + S_point) n,

and d^2 / var d is chi-square with one degree of freedom.  S_eop is common to all points of an image, S_curve to
neighbours on a curve: the share of the variance that neighbours have in common is kept apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.matching.candidates.search import Candidates, find_candidates
from splinebba_cli.core.matching.known_curves.bends import turns_within_noise
from splinebba_cli.core.matching.known_curves.chain_directions import Directions
from splinebba_cli.core.matching.known_curves.uncertainty import Uncertainty
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray

CHUNK = 200_000
CLEAR = 0.5  # rad, sigma of a direction that may contradict a curve


@dataclass(frozen=True)
class Gated:
    """Candidates with what the gate says of them; one row a candidate."""

    candidates: Candidates
    across: FloatArray  # (k,) mm, signed
    noise: FloatArray  # (k,) variance of the point across, mm^2
    common: FloatArray  # (k,) variance that neighbours share, mm^2
    square: FloatArray  # (k,) d^2 / var, with what lies beyond an end of the curve
    turn: FloatArray  # (k,) rad, from the edge to the projected curve, up to a right angle; NaN unknown
    turn_sigma: FloatArray  # (k,) rad, of the direction of the edge
    inside: BoolArray  # (k,) of the gate
    agrees: BoolArray  # (k,) in direction


def gate_candidates(
    scene: Scene, uncertainty: Uncertainty, directions: Directions, alpha: float, tolerance: float
) -> Gated:
    """All candidates near the points of a scene, those inside of the gate marked.

    Parameters
    ----------
    alpha : share of right points that the gate loses
    tolerance : rad, of directions
    """
    limit = float(chdtri(1, alpha))
    candidates = find_candidates(scene, _radius(scene, uncertainty, limit))
    parts = [
        _variances(scene, uncertainty, candidates, slice(begin, begin + CHUNK))
        for begin in range(0, len(candidates), CHUNK)
    ] or [(np.zeros(0),) * 4]
    across, noise, common, beyond = (np.concatenate(each) for each in zip(*parts, strict=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        square = across**2 / (noise + common) + beyond**2 / (noise + common)
    point, inside = candidates.point, square <= limit
    angle, deviation = directions.angle[point], np.minimum(directions.sigma[point], 1.0)
    turn = turns_within_noise(scene, candidates, angle, inside & (deviation < CLEAR))
    agrees = np.isnan(turn) | (np.abs(turn) <= tolerance + 3.0 * deviation)
    return Gated(candidates, across, noise, common, square, turn, deviation, inside, agrees)


def _radius(scene: Scene, uncertainty: Uncertainty, limit: float) -> FloatArray:
    """Radius (n,) mm that holds the gate: of the worst direction, from a few points of the image."""
    common = uncertainty.largest_in_photo(scene)
    return np.asarray(
        np.sqrt(limit * ((uncertainty.noise_factor * scene.noise) ** 2 + common[scene.image] ** 2))
    )


def _variances(
    scene: Scene, uncertainty: Uncertainty, candidates: Candidates, rows: slice
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Signed distance across, variance of the point, common variance, distance beyond an end; of some candidates."""
    point, curve, u = candidates.point[rows], candidates.curve[rows], candidates.location[rows]
    tangent, offset = candidates.tangent[rows], candidates.offset[rows]
    image = scene.image[point]
    xyz = scene.curves.evaluate(scene.coefficients, curve, u)[0]
    _, jacobian = project_with_jacobian(
        scene.principal_distance[image], scene.rotation[image], scene.position[image], xyz
    )
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    across = np.sum(normal * offset, axis=1)
    beyond = np.sum(tangent * offset, axis=1)  # 0 but at ends and corners
    g = np.matmul(normal[:, None, :], jacobian.orientation)[:, 0]
    of_images = uncertainty.of_images(image, g)
    h = np.matmul(normal[:, None, :], jacobian.object_xyz)[:, 0]
    of_curves = uncertainty.of_curves(scene, curve, u, h)
    w = np.linalg.solve(scene.whitening[point].transpose(0, 2, 1), normal[:, :, None])[:, :, 0]
    noise = uncertainty.noise_factor**2 * np.sum(w * w, axis=1)
    return across, noise, of_images + of_curves, beyond
