"""Depth and slope of depth that a chain of another image gives to a point of the reference image, with sigma.

An object point X0 + depth ray moves in the other photo by J ray d(depth); the chain there takes it across itself:

    sigma(depth)^2 = (sigma_there^2 + (n' J m depth sigma_here)^2) / (n' J ray)^2

with n the normal of the chain there and m the direction across the chain here, in space.  The tangent of the curve
lies in the planes of both tangents,

    t = depth d(ray)/ds + slope ray,    N' t = 0,    N = normal of the plane of the tangent there

so that two images predict the direction in which a third one sees the curve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.crossings import Crossings
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

SAME_DIRECTION = 0.9  # cosine of the tangents at both ends of a step: below, there is a corner between
SURE = 2.0  # sigma by which the direction of the chain must differ from that of the epipolar line
SLOWEST = 0.2  # place there over place here along a step: below, the curve would run along a line of sight


@dataclass(frozen=True)
class Hypotheses:
    """One crossing each, sorted by point and depth."""

    point: IntArray  # (k,) of the chains
    image: IntArray  # (k,) the other image
    place: FloatArray  # (k,) number of the point of the chains there, with fraction
    depth: FloatArray  # (k,) m/mm
    sigma: FloatArray  # (k,)
    slope: FloatArray  # (k,) d depth / d mm along the reference chain
    slope_sigma: FloatArray  # (k,)

    def __len__(self) -> int:
        return len(self.point)


def depth_hypotheses(views: Views, chains: TracedChains, crossings: Crossings) -> Hypotheses:
    """Depths with sigma of crossings; those at a grazing angle are left out."""
    here, first = crossings.point, crossings.first
    image = chains.image[first]
    ray = chains.ray[here]
    depth = crossings.depth
    xyz = views.position[chains.image[here]] + depth[:, None] * ray
    _, jacobian = views.project_with_jacobian(image, xyz)
    tangent, tangent_sigma, sigma = on_chain(chains, first, crossings.fraction)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    forward = views.turned(chains.image[here], chains.tangent[here])
    sideways = views.turned(chains.image[here], chains.normal[here])

    moved = np.matmul(jacobian, np.stack([ray, forward, sideways], axis=2))  # (k, 2, 3)
    by_depth, by_forward, by_side = moved[:, :, 0], moved[:, :, 1] * depth[:, None], moved[:, :, 2]
    across = np.sum(normal * by_depth, axis=1)
    speed = np.linalg.norm(by_depth, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        noise = np.hypot(sigma, np.sum(normal * by_side, axis=1) * depth * chains.sigma[here])
        depth_sigma = noise / np.abs(across)
        slope = -np.sum(normal * by_forward, axis=1) / across
        along = by_forward + slope[:, None] * by_depth
        length = np.sum(along**2, axis=1)
        turn = np.abs(_cross(along, by_depth)) / length
        turn_here = np.abs(_cross(along, by_side * depth[:, None])) / length
        slope_sigma = np.hypot(tangent_sigma, turn_here * chains.tangent_sigma[here]) / turn
        good = np.isfinite(slope_sigma) & (np.abs(across) > SURE * tangent_sigma * speed)
        advance = np.sqrt(length / np.sum(by_forward**2, axis=1))
        good &= (advance > SLOWEST) & (advance < 1.0 / SLOWEST)
    rows = np.flatnonzero(good)
    rows = rows[np.lexsort((depth[rows], here[rows]))]
    return Hypotheses(
        here[rows], image[rows], first[rows] + crossings.fraction[rows], depth[rows], depth_sigma[rows],
        slope[rows], slope_sigma[rows],
    )  # fmt: skip


def on_chain(
    chains: TracedChains, first: IntArray, fraction: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Tangent, its sigma and the noise across, at places of a chain."""
    one, two = chains.tangent[first], chains.tangent[first + 1]
    step = chains.xy[first + 1] - chains.xy[first]
    mixed = one + fraction[:, None] * (two - one)
    corner = np.sum(one * two, axis=1) < SAME_DIRECTION
    tangent = np.where(corner[:, None], step, mixed)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    tangent_sigma = np.maximum(chains.tangent_sigma[first], chains.tangent_sigma[first + 1])
    return tangent, tangent_sigma, np.maximum(chains.sigma[first], chains.sigma[first + 1])


def _cross(one: FloatArray, two: FloatArray) -> FloatArray:
    return np.asarray(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
