"""Many orientations moved at once so that projected curves run along the chains: from samples to the raster's points.

The samples of the curves are brought to the straight line through the nearest chain point (point to line), step by
step with a smaller gate where the distances allow it.  A raster says which point is nearest, so that chains closer to
each other than its cells are confused: what comes out is good enough to be told from the others, and to start the exact
refinement (refinement.py).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.matching.free_orientation.chain_raster import ChainRaster
from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.places import CurveSamples
from splinebba_cli.core.matching.free_orientation.seen import across_design, see
from splinebba_cli.core.network import FloatArray, IntArray

TOGETHER = 100  # orientations
SHRINK = 0.75  # of the gate from step to step
LAST_STEPS = 6  # with the narrowest gate
WIDTH = 4.0  # times the spread of the distances, below which no gate shrinks
FEWEST = 12  # samples on chains
DETERMINED = 1e-12  # smallest over largest eigenvalue of normal equations


def roughly_refined(
    chains: ImageChains,
    samples: CurveSamples,
    raster: ChainRaster,
    rotation: FloatArray,
    position: FloatArray,
    gate: float,
    narrowest: float,
) -> tuple[FloatArray, FloatArray]:
    """Orientations (s, 3, 3), (s, 3) moved onto the chains; those that lead nowhere are NaN.

    Parameters
    ----------
    gate, narrowest : mm, of the first step and of the last ones
    """
    rotation, position = rotation.copy(), position.copy()
    count = max(int(np.ceil(np.log(narrowest / gate) / np.log(SHRINK))), 0) + LAST_STEPS
    for begin in range(0, len(rotation), TOGETHER):
        own = slice(begin, begin + TOGETHER)
        width = np.full(len(rotation[own]), gate)
        for _ in range(count):
            rotation[own], position[own], spread = _step(
                chains, samples, raster, rotation[own], position[own], width
            )
            width = np.maximum(np.maximum(SHRINK * width, narrowest), np.minimum(width, WIDTH * spread))
    return rotation, position


def _step(
    chains: ImageChains,
    samples: CurveSamples,
    raster: ChainRaster,
    rotation: FloatArray,
    position: FloatArray,
    gate: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """One Gauss-Newton step, distances weighted down towards the gates (Tukey); rms of the weighted distances."""
    count = len(rotation)
    seen = see(chains, samples, rotation, position)
    beside = raster.beside(seen, gate)
    rows = np.flatnonzero(beside.hit)
    pose, sample, distance = beside.pose[rows], beside.sample[rows], beside.distance[rows]
    depth, c = seen.depth[pose, sample], chains.principal_distance
    p = np.stack([seen.x[pose, sample] * depth / c, seen.y[pose, sample] * depth / c, -depth], axis=1)
    design = across_design(c, p, beside.normal[rows], rotation[pose])
    weight = (1.0 - (distance / gate[pose]) ** 2) ** 2
    sums = _sums(np.column_stack([design, distance]), design * weight[:, None], pose, count)
    step = _solved(sums[:, :6], -sums[:, 6])
    step[np.bincount(pose, minlength=count) < FEWEST] = np.nan
    total = np.maximum(np.bincount(pose, weight, minlength=count), 1e-300)
    spread = np.sqrt(np.bincount(pose, weight * distance**2, minlength=count) / total)
    with np.errstate(invalid="ignore"):
        return rotation @ rotation_from_vector(step[:, :3]), position + step[:, 3:], spread


def _sums(left: FloatArray, right: FloatArray, pose: IntArray, count: int) -> FloatArray:
    """Sums over the rows (k, a), (k, b) of every orientation of their outer products, (count, a, b)."""
    number = np.bincount(pose, minlength=count)
    filled = np.flatnonzero(number)
    out = np.zeros((count, left.shape[1], right.shape[1]))
    if len(filled):
        start = np.cumsum(number) - number
        out[filled] = np.add.reduceat(left[:, :, None] * right[:, None], start[filled], axis=0)
    return out


def _solved(normal_matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Least steps that solve scaled normal equations (s, 6, 6), (s, 6): (s, 6)."""
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("sii->si", normal_matrix), 1e-300))
    inverse = np.linalg.pinv(
        normal_matrix * scale[:, :, None] * scale[:, None], rcond=DETERMINED, hermitian=True
    )
    return np.asarray(scale * np.matmul(inverse, (scale * right)[:, :, None])[:, :, 0])
